//! Each command, from its arguments to its exit code.

use crate::cli::{Cli, Command};
use crate::command;
use crate::exit::{BenchError, Exit};
use crate::scene_file::{SceneFile, schema};
use clap::CommandFactory;
use std::io::Write;

/// Runs a command; what it is asked to print goes to `stdout`.
pub fn run(cli: &Cli, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    match (&cli.command, &cli.run) {
        (Some(Command::Check(args)), _) => command::check(args, stdout),
        (Some(Command::Dataset(args)), _) => command::dataset(args, stdout),
        #[cfg(feature = "train")]
        (Some(Command::Train(args)), _) => command::train(args, stdout),
        (Some(Command::Schema), _) => {
            stdout.write_all(schema::<SceneFile>()?.as_bytes())?;
            Ok(Exit::Success)
        }
        (None, Some(args)) => command::bench(args, stdout),
        (None, None) => {
            write!(stdout, "{}", Cli::command().render_help())?;
            Ok(Exit::BadInput)
        }
    }
}
