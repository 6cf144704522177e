//! `bench calibrate` and `bench headroom`.

use super::MakingArgs;
use clap::Args;
use clap::builder::RangedI64ValueParser;
use serde::Serialize;
use std::path::PathBuf;

/// `bench calibrate SCENE [N]`: the estimator's settings on validation objects.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct CalibrateArgs {
    /// On what.
    #[command(flatten)]
    pub validation: ValidationArgs,
    /// Folder of a trained model, or its name (`bench list`), in place of the one that comes with the scene.
    #[arg(long, value_name = "DIR")]
    pub model: Option<PathBuf>,
}

/// Episodes with validation objects, under seeds that no table uses.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct ValidationArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Number of episodes.
    #[arg(value_name = "N", default_value_t = 30, allow_negative_numbers = true, value_parser = RangedI64ValueParser::<u64>::new().range(1..=1000))]
    pub episodes: u64,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
}
