//! The command line of `bench`.

mod choice;
mod gate;
mod import;
mod look;
mod loudness;
mod report;
mod run;
mod score;
mod stages;
mod sweep;
mod task;
mod train;
mod validation;

use choice::command_name;
pub use choice::{DatasetFormat, ImportLayout, RendererChoice, ReportFormat, SplitChoice, TablesChoice};
pub use gate::{BaselineArgs, CheckArgs};
pub use import::ImportArgs;
pub use look::{FiguresArgs, LookArgs};
pub use loudness::LoudnessArgs;
pub use report::ReportArgs;
pub use run::RunArgs;
pub use score::ScoreArgs;
pub use stages::{MakingArgs, StageArgs};
pub use sweep::{SweepArgs, SweepCommand};
pub use task::{AssociationChoice, TaskArgs};
pub use train::{StudyArgs, TrainArgs};
pub use validation::{CalibrateArgs, ValidationArgs};

use super::help::{EXAMPLES, EXIT_CODES};
use clap::builder::RangedI64ValueParser;
use clap::{Args, Parser, Subcommand};
use serde::Serialize;
use std::path::PathBuf;

/// Benchmark for SLAM with learned, viewpoint-dependent object semantics.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(name = "bench", version, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(arg_required_else_help = true, after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub struct Cli {
    /// Another thing to do than to run a scene.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The scene to run, and how.
    #[command(flatten)]
    pub run: RunArgs,
    /// How much is said.
    #[command(flatten)]
    pub loudness: LoudnessArgs,
}

/// What `bench` does.
#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum Command {
    /// Makes the results anew that later runs are checked against, and writes down why.
    Baseline(BaselineArgs),
    /// Tries the estimator's settings on validation objects: box errors, and the worth of a crop.
    Calibrate(CalibrateArgs),
    /// Compares fresh results with the committed ones.
    Check(CheckArgs),
    /// Writes crops, detections, odometry and truth as files.
    Dataset(DatasetArgs),
    /// Draws what a model makes of objects it has not seen: t-SNE of latents, predicted views, likely viewpoints.
    Figures(FiguresArgs),
    /// Tells what viewpoints are worth in a scene: ATE with an ideal sensor of azimuths, on validation objects.
    Headroom(ValidationArgs),
    /// Writes the index of a folder of results, and their tables anew.
    Index(IndexArgs),
    /// Reads BigBIRD, Active Vision or BOP data, or a folder of photographs, into our own layout.
    Import(ImportArgs),
    /// Lists scenes, models, studies and maps that come with the program.
    List,
    /// Draws the scene at a glance: the world from above, what the camera sees, crops.
    Look(LookArgs),
    /// Runs one scene in many cells, compares all rows in each, and draws where which gains.
    Map(MapArgs),
    /// Checks model folders and tells what they hold: kind, sizes, graphs, origin, time of a call.
    Models(ModelsArgs),
    /// Writes finished results as one page that needs no network, as Markdown or as LaTeX.
    Report(ReportArgs),
    /// Tells how far two trajectories are apart, as evo does: APE and RPE.
    Score(ScoreArgs),
    /// Trains models in several ways on the same views and compares them (`--features train`).
    Study(StudyArgs),
    /// Splits a scene, a study or a map into tasks for several machines.
    Sweep(SweepArgs),
    /// Writes a scene's episodes without their truth, for others to answer, and the truth elsewhere.
    Task(TaskArgs),
    /// Trains the scene's model from scratch (`--features train`).
    Train(TrainArgs),
    /// Prints the JSON schema (draft 07) of scene files.
    Schema,
    /// Prints what completes commands and options in a shell.
    Completions(CompletionsArgs),
    /// Prints the man page, or that of a command.
    Man(ManArgs),
}

/// `bench index RESULTS_DIR`: the index of a folder of results, and their tables.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct IndexArgs {
    /// The folder that holds `scenes` and `studies`.
    #[arg(value_name = "RESULTS_DIR")]
    pub results: PathBuf,
}

/// `bench dataset SCENE --out DIR`: crops, detections, odometry and truth as files.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct DatasetArgs {
    /// The scene: a file, or the name of one that comes with the program.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Folder that gets the dataset.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Formats, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "vantage")]
    pub format: Vec<DatasetFormat>,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
    /// Seeds 0 to N - 1 instead of those of the scene.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = RangedI64ValueParser::<u64>::new().range(1..=100_000))]
    pub seeds: Option<u64>,
    /// Which of the disjoint sets of instances the objects are drawn from.
    #[arg(long, value_enum, default_value_t)]
    pub split: SplitChoice,
}

/// `bench map FILE`: one scene in many cells.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct MapArgs {
    /// The map: a file, or the name of one that comes with the program.
    #[arg(value_name = "MAP")]
    pub map: PathBuf,
    /// Folder that gets `maps/NAME`, the results of the map of that name: `results` for those that are committed.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Gives up a result of more seeds, or with cells that the run lacks, that lies in the folder.
    #[arg(long)]
    #[serde(skip)]
    pub replace: bool,
    /// Where from, and what renders.
    #[command(flatten)]
    #[serde(flatten)]
    pub making: MakingArgs,
    /// Seeds 0 to N - 1 instead of those of the map.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = RangedI64ValueParser::<u64>::new().range(1..=1000))]
    pub seeds: Option<u64>,
}

/// `bench models DIR...`: what model folders hold.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct ModelsArgs {
    /// The folders, or names of models that come with the program (`bench list`).
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Folder of intermediate results: a model that comes with the program is laid out in it.
    #[arg(long, value_name = "DIR", default_value = "cache")]
    pub cache: PathBuf,
}

/// `bench completions SHELL`: for a shell's completion.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum, value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// `bench man [COMMAND]`: a man page.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct ManArgs {
    /// A command, in place of the whole program.
    #[arg(value_name = "COMMAND", value_parser = command_name)]
    pub command: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parse(arguments: &str) -> Result<RunArgs, String> {
        let words = std::iter::once("bench").chain(arguments.split_whitespace());
        let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
        if cli.command.is_some() { Err("a command".to_owned()) } else { Ok(cli.run) }
    }

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_scene_alone_has_documented_defaults() {
        let run = parse("scenes/tabletop.yaml").unwrap();
        assert_eq!(
            (run.out.as_path(), run.stages.making.cache.as_path()),
            ("out".as_ref(), "cache".as_ref())
        );
        assert_eq!(
            (run.stages.making.renderer, run.stages.seeds, run.stages.train),
            (RendererChoice::Auto, None, false)
        );
    }

    #[test]
    fn all_options_are_read_and_wrong_ones_refused() {
        let run = parse("s.yaml --out o --cache c --renderer reference --model m --seeds 3").unwrap();
        assert_eq!((run.stages.making.renderer, run.stages.seeds), (RendererChoice::Reference, Some(3)));
        assert_eq!(run.stages.model, [PathBuf::from("m")]);
        for wrong in ["", "s.yaml --seeds 0", "s.yaml --renderer gl", "s.yaml --train --model m", "s.yaml -x"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
