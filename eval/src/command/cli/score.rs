//! Options of `bench score`.

use super::choice::positive;
use crate::score::alignment::Alignment;
use crate::score::pairs::MAX_TIME_DIFFERENCE;
use crate::score::pose_error::{Spacing, Unit};
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
    /// What of the estimate's frame is free [default: origin].
    #[arg(long, value_enum)]
    pub align: Option<Alignment>,
    /// Of RPE: how far apart the two poses of a motion are [default: 1].
    #[arg(long, value_name = "N", value_parser = positive)]
    pub delta: Option<f64>,
    /// In what `--delta` is counted [default: frames].
    #[arg(long, value_enum)]
    pub unit: Option<Unit>,
    /// Of RPE: motions from every pose, in place of one after the other.
    #[arg(long)]
    pub all_pairs: bool,
    /// Poses so many seconds apart at most are of one time [default: 0.01].
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub max_difference: Option<f64>,
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

impl ScoreArgs {
    /// What of the estimate's frame is free.
    pub fn alignment(&self) -> Alignment {
        self.align.unwrap_or_default()
    }

    /// Which two poses a motion is between.
    pub fn spacing(&self) -> Spacing {
        let (delta, unit) = (self.delta.unwrap_or(1.0), self.unit.unwrap_or_default());
        Spacing { delta, unit, all_pairs: self.all_pairs }
    }

    /// How far apart poses of one time are at most, seconds.
    pub fn nearness(&self) -> f64 {
        self.max_difference.unwrap_or(MAX_TIME_DIFFERENCE)
    }

    /// The first option that is given and that means something of two trajectories alone.
    pub fn of_trajectories(&self) -> Option<&'static str> {
        let options = [
            ("--align", self.align.is_some()),
            ("--delta", self.delta.is_some()),
            ("--unit", self.unit.is_some()),
            ("--all-pairs", self.all_pairs),
            ("--max-difference", self.max_difference.is_some()),
            ("--evo", self.evo.is_some()),
            ("--map", self.map.is_some()),
            ("--true-map", self.true_map.is_some()),
        ];
        options.into_iter().find_map(|(option, is_given)| is_given.then_some(option))
    }
}
