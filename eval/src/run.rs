//! Each command, from its arguments to its exit code.

use crate::cli::{Cli, Command};
use crate::command;
use crate::error::BenchError;
use crate::exit::Exit;
use crate::scene_file::{SceneFile, schema};
use std::io::Write;

/// Runs a command; what it is asked to print goes to `stdout`.
pub fn run(cli: &Cli, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    match &cli.command {
        None => command::bench(&cli.run, stdout),
        Some(Command::Check(args)) => command::check(args, stdout),
        Some(Command::Dataset(args)) => command::dataset(args, stdout),
        Some(Command::Figures(args)) => command::figures(args, stdout),
        Some(Command::Import(args)) => command::import(args, stdout),
        Some(Command::Look(args)) => command::look(args, stdout),
        Some(Command::Models(args)) => command::models(args, stdout),
        #[cfg(feature = "train")]
        Some(Command::Study(args)) => command::study(args, stdout),
        #[cfg(feature = "train")]
        Some(Command::Train(args)) => command::train(args, stdout),
        Some(Command::Schema) => {
            stdout.write_all(schema::<SceneFile>()?.as_bytes())?;
            Ok(Exit::Success)
        }
    }
}
