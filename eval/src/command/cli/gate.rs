//! Options of `bench check` and `bench baseline`.

use super::StageArgs;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// `bench check SCENE`: fresh results against the committed ones.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct CheckArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Folder of the committed results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    pub baseline: PathBuf,
    /// File that gets the verdict as JUnit XML, a test case for each score, for continuous integration.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// File that gets the verdict as Markdown, as for a comment on a change.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// File that gets every comparison as JSON, SI units.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub stages: StageArgs,
}

/// `bench baseline SCENE --why TEXT`: results to be checked against.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct BaselineArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Why the baseline changes, in a line.
    #[arg(long, value_name = "TEXT")]
    pub why: String,
    /// Folder of the committed results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    pub baseline: PathBuf,
    /// How it is made.
    #[command(flatten)]
    pub stages: StageArgs,
}
