//! Options that commands have in common: where intermediate results lie, what renders, which models, seeds and trajectories.

use super::RendererChoice;
use clap::Args;
use clap::builder::RangedI64ValueParser;
use serde::Serialize;
use std::path::PathBuf;

/// Options of every command that renders.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct MakingArgs {
    /// Folder of intermediate results, which a second run takes up, and of what comes with the program.
    #[arg(long, value_name = "DIR", default_value = "cache")]
    pub cache: PathBuf,
    /// What renders.
    #[arg(long, value_enum, default_value_t)]
    pub renderer: RendererChoice,
}

/// Options of every command that runs all stages.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct StageArgs {
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
    /// Trains the model from scratch instead of taking the one that comes with the scene (`--features train`).
    #[arg(long, conflicts_with = "model")]
    pub train: bool,
    /// Folder of a trained model, or its name (`bench list`); its row has that name. May be given more than once.
    #[arg(long, value_name = "DIR")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub model: Vec<PathBuf>,
    /// Seeds 0 to N - 1 instead of those of the scene.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = RangedI64ValueParser::<u64>::new().range(1..=1000))]
    pub seeds: Option<u64>,
    /// Folder of another estimator's trajectories, `<seed>.tum` each; its row has the folder's name. May be given more than once.
    #[arg(long, value_name = "DIR")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub trajectories: Vec<PathBuf>,
}
