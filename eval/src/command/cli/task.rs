//! Options of `bench task`.

use super::stages::MakingArgs;
use clap::builder::RangedI64ValueParser;
use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// `bench task SCENE --out DIR --truth DIR --secret FILE`: episodes without their truth, and the truth elsewhere.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct TaskArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Folder that gets what is published: what a robot observes, and the hash of the truth.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Folder that gets the sealed truth, which is kept back.
    #[arg(long, value_name = "DIR")]
    pub truth: PathBuf,
    /// A file of at least 16 characters that nobody guesses: seeds are drawn from it, and whoever knows it can make the truth anew.
    #[arg(long, value_name = "FILE")]
    #[serde(skip)]
    pub secret: PathBuf,
    /// How many episodes.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = RangedI64ValueParser::<u64>::new().range(1..=1000))]
    pub episodes: u64,
    /// What is told of who is who.
    #[arg(long, value_enum, default_value_t)]
    pub association: AssociationChoice,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
}

/// What a robot is told of which detections are of one object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AssociationChoice {
    /// All.
    #[default]
    Given,
    /// As long as the object stays in view.
    Tracklets,
    /// Nothing.
    None,
}
