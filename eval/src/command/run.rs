//! Each command, from its arguments to its exit code.

use super::cli::{Cli, Command};
use super::source;
use crate::command::error::BenchError;
use crate::exit::Exit;
#[cfg(not(feature = "train"))]
use crate::left_out::LeftOut;
use crate::progress::Loudness;
use crate::scene_file::{SceneFile, schema};
use std::io::Write;

/// Runs a command; what it is asked to print goes to `stdout`.
pub fn run(mut cli: Cli, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    Loudness::from(cli.loudness).apply();
    source::find(&mut cli)?;
    match &cli.command {
        None => super::bench(&cli.run, stdout),
        Some(Command::Baseline(args)) => super::baseline(args, stdout),
        Some(Command::Calibrate(args)) => super::calibrate(args, stdout),
        Some(Command::Check(args)) => super::check(args, stdout),
        Some(Command::Dataset(args)) => super::dataset(args, stdout),
        Some(Command::Figures(args)) => super::figures(args, stdout),
        Some(Command::Headroom(args)) => super::headroom(args, stdout),
        Some(Command::Index(args)) => super::write_index(args, stdout),
        Some(Command::Import(args)) => super::import(args, stdout),
        Some(Command::List) => super::list(stdout),
        Some(Command::Look(args)) => super::look(args, stdout),
        Some(Command::Map(args)) => super::map(args, stdout),
        Some(Command::Models(args)) => super::models(args, stdout),
        Some(Command::Report(args)) => super::report(args, stdout),
        Some(Command::Score(args)) => super::score(args, stdout),
        Some(Command::Sweep(args)) => super::sweep(args, stdout),
        Some(Command::Task(args)) => super::task(args, stdout),
        #[cfg(feature = "train")]
        Some(Command::Study(args)) => super::study(args, stdout),
        #[cfg(feature = "train")]
        Some(Command::Train(args)) => super::train(args, stdout),
        #[cfg(not(feature = "train"))]
        Some(Command::Study(_) | Command::Train(_)) => Err(LeftOut::Training.into()),
        Some(Command::Schema) => {
            stdout.write_all(schema::<SceneFile>()?.as_bytes())?;
            Ok(Exit::Success)
        }
        Some(Command::Completions(args)) => super::completions(args, stdout),
        Some(Command::Man(args)) => super::man(args, stdout),
    }
}
