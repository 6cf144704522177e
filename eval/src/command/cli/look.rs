//! `bench look` and `bench figures`.

use super::MakingArgs;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// `bench look SCENE`: the scene as one picture.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct LookArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// The PNG file, not the folder, to write; by default `out/NAME.png` after the scene's name.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// A Rerun file to write the episode of the first seed to. Needs a program built with `--features rerun`.
    #[arg(long, value_name = "FILE.rrd")]
    pub rerun: Option<PathBuf>,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
}

/// `bench figures SCENE --out DIR`: a model as pictures.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct FiguresArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Folder that gets the pictures.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
    /// Folder of a trained model, or its name (`bench list`), in place of the one that comes with the scene.
    #[arg(long, value_name = "DIR")]
    pub model: Option<PathBuf>,
    /// A view set to draw, as `bench import` makes them, in place of the scene's test instances.
    #[arg(long, value_name = "DIR")]
    pub views: Option<PathBuf>,
}
