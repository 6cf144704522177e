//! Options of `bench score`.

use super::choice::positive;
use crate::score::alignment::Alignment;
use crate::score::pairs::MAX_TIME_DIFFERENCE;
use crate::score::pose_error::Unit;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// `bench score TRUTH ESTIMATE`: how far two trajectories are apart; of folders, what a submission to a task is worth.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct ScoreArgs {
    /// The true trajectory: a file of TUM's, KITTI's or EuRoC's. Or the folder of a task's sealed truth.
    #[arg(value_name = "TRUTH")]
    pub truth: PathBuf,
    /// The estimated one. Or the folder of a submission to that task.
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
    /// Folder that gets the results for evo: `ape_translation.zip` and so on, which `evo_res` reads.
    #[arg(long, value_name = "DIR")]
    pub evo: Option<PathBuf>,
    /// A map of objects in the estimate's frame, a CSV file with columns x, y, z and others.
    #[arg(long, value_name = "FILE", requires = "true_map")]
    pub map: Option<PathBuf>,
    /// The true one, in the frame of the true trajectory, with labels.
    #[arg(long, value_name = "FILE", requires = "map")]
    pub true_map: Option<PathBuf>,
    /// Of a submission: the task as it was published, whose truth it has to be.
    #[arg(long, value_name = "DIR")]
    pub task: Option<PathBuf>,
    /// Prints JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}
