//! Options of `bench score`.

use super::choice::positive;
use crate::score::alignment::Alignment;
use crate::score::pairs::MAX_TIME_DIFFERENCE;
use crate::score::pose_error::Unit;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// `bench score TRUTH ESTIMATE`: how far two trajectories are apart.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct ScoreArgs {
    /// The true trajectory: a file of TUM's, KITTI's or EuRoC's.
    #[arg(value_name = "TRUTH")]
    pub truth: PathBuf,
    /// The estimated one.
    #[arg(value_name = "ESTIMATE")]
    pub estimate: PathBuf,
    /// What of the estimate's frame is free.
    #[arg(long, value_enum, default_value_t)]
    pub align: Alignment,
    /// Of RPE: how far apart the two poses of a motion are.
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = positive)]
    pub delta: f64,
    /// In what `--delta` is counted.
    #[arg(long, value_enum, default_value_t)]
    pub unit: Unit,
    /// Of RPE: motions from every pose, in place of one after the other.
    #[arg(long)]
    pub all_pairs: bool,
    /// Poses so many seconds apart at most are of one time.
    #[arg(long, value_name = "SECONDS", default_value_t = MAX_TIME_DIFFERENCE, value_parser = positive)]
    pub max_difference: f64,
    /// Prints JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}
