//! `bench SCENE`.

use super::{StageArgs, TablesChoice};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// `bench SCENE`: from a scene file to tables.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct RunArgs {
    /// The scene to run: a file, or the name of one that comes with the program (`bench list`).
    #[arg(value_name = "SCENE", required = true)]
    pub scene: Option<PathBuf>,
    /// Folder that gets `scenes/NAME`, the results of the scene of that name: `results` for those that are committed.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Gives up a result of more seeds or of another model that lies in the folder.
    #[arg(long)]
    #[serde(skip)]
    pub replace: bool,
    /// Estimates also after every step, as a robot would: adds a table, `online.svg`, `step_errors.csv`, `step_times.md`
    /// and, of the newest poses, `<seed>/<method>.online.tum`.
    #[arg(long)]
    #[serde(skip)]
    pub online: bool,
    /// Leaves also what scores are made of, for NumPy: `<seed>/truth.npz`, `<seed>/<row>.npz`, `<seed>/<model>.latents.npz`,
    /// and with `--online` `<seed>/<row>.online.npz`.
    #[arg(long)]
    #[serde(skip)]
    pub dump: bool,
    /// Asks also who is who, where estimators are told less than all: adds a table, and `<seed>/<row>.association.csv`.
    #[arg(long)]
    #[serde(skip)]
    pub associate: bool,
    /// Folder of another associator's answers, `<seed>.csv` each; its row has the folder's name, and `--associate` is meant. May be given more
    /// than once.
    #[arg(long, value_name = "DIR")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub associations: Vec<PathBuf>,
    /// Which tables are printed.
    #[arg(long, value_enum, default_value_t)]
    #[serde(skip)]
    pub tables: TablesChoice,
    /// Prints the results as JSON, and nothing else.
    #[arg(long, conflicts_with = "tables")]
    #[serde(skip)]
    pub json: bool,
    /// How it is made.
    #[command(flatten)]
    pub stages: StageArgs,
}
