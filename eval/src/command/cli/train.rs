//! `bench train` and `bench study`.

use super::MakingArgs;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// `bench train SCENE --out DIR`: the scene's model.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct TrainArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Folder that gets the model.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
    /// A view set to train on, in place of the scene's.
    #[arg(long, value_name = "DIR", requires = "validation_views")]
    pub views: Option<PathBuf>,
    /// A view set of other objects to calibrate on.
    #[arg(long, value_name = "DIR", requires = "views")]
    pub validation_views: Option<PathBuf>,
    /// Trains on a GPU. Needs a program built with `--features gpu`.
    #[arg(long)]
    pub gpu: bool,
}

/// `bench study FILE`: models compared.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct StudyArgs {
    /// The study: a file, or the name of one that comes with the program.
    #[arg(value_name = "STUDY")]
    pub study: PathBuf,
    /// Folder that gets `studies/NAME`, the results of the study of that name: `results` for those that are committed.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
}
