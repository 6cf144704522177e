//! `bench completions SHELL` and `bench man [COMMAND]`: files that a shell and `man` read.

use super::cli::{Cli, CompletionsArgs, ManArgs};
use crate::command::error::BenchError;
use crate::exit::Exit;
use clap::CommandFactory;
use std::io::Write;

/// Prints what completes commands and options in a shell.
pub fn completions(args: &CompletionsArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "bench", &mut script);
    stdout.write_all(&script)?;
    Ok(Exit::Success)
}

/// Prints the man page of the program, or of one of its commands.
pub fn man(args: &ManArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let mut page = Cli::command();
    page.build();
    if let Some(name) = &args.command
        && let Some(command) = page.find_subcommand(name)
    {
        page = command.clone();
    }
    clap_mangen::Man::new(page).render(stdout)?;
    Ok(Exit::Success)
}
