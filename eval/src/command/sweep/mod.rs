//! `bench sweep`: a scene, a study or a map in numbered tasks, on as many machines as share a folder of intermediate results.
//!
//! A task does its share of the stages and leaves them in the cache. When all are done, the whole command is run, which then finds all of them
//! there: what it writes is what one process would have written.

pub mod error;
mod job;
mod part;
mod plan;

pub use part::Part;

use super::cli::{Cli, Command, SweepArgs, SweepCommand};
use super::source;
use crate::command::error::BenchError;
use crate::exit::Exit;
use error::SweepError;
use plan::Plan;
use std::io::Write;
use std::path::Path;

/// Plans, does a task, says what does all of them, or puts them together.
pub fn sweep(args: &SweepArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    match &args.command {
        SweepCommand::Plan { tasks, out, command } => {
            let cli = parsed(command)?;
            let plan = Plan::new(*tasks, command, &cli)?;
            plan.write(out)?;
            let out = out.display();
            writeln!(
                stdout,
                "{tasks} tasks, from 0 on: `bench sweep run {out} --index N`, then `bench sweep merge {out}`"
            )?;
            Ok(Exit::Success)
        }
        SweepCommand::Run { plan: folder, index } => run(folder, *index, stdout),
        SweepCommand::Merge { plan: folder } => {
            let plan = Plan::read(folder)?;
            let missing: Vec<usize> =
                (0..plan.tasks).filter(|index| !Plan::is_done(folder, *index)).collect();
            if !missing.is_empty() {
                return Err(SweepError::Missing { folder: folder.clone(), missing }.into());
            }
            let cli = parsed(&plan.command)?;
            plan.check(&cli)?;
            whole(&cli, stdout)
        }
        SweepCommand::Slurm { plan: folder } => {
            write!(stdout, "{}", job::slurm(folder, Plan::read(folder)?.tasks)?)?;
            Ok(Exit::Success)
        }
        SweepCommand::Kubernetes { plan: folder, image, claim } => {
            write!(stdout, "{}", job::kubernetes(folder, Plan::read(folder)?.tasks, image, claim)?)?;
            Ok(Exit::Success)
        }
    }
}

fn run(folder: &Path, index: Option<usize>, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let plan = Plan::read(folder)?;
    let index = index.map_or_else(plan::index_of_environment, Ok)?;
    if index >= plan.tasks {
        return Err(SweepError::NoTask { index, tasks: plan.tasks }.into());
    }
    if Plan::is_done(folder, index) {
        writeln!(stdout, "task {index} is done already")?;
        return Ok(Exit::Success);
    }
    let cli = parsed(&plan.command)?;
    plan.check(&cli)?;
    let part = Part { index, of: plan.tasks };
    match &cli.command {
        None => super::scene::part(&cli.run, part)?,
        #[cfg(feature = "train")]
        Some(Command::Study(args)) => super::study::part(args, part)?,
        Some(Command::Map(args)) => super::map::part(args, part)?,
        _ => return Err(SweepError::Unsplit.into()),
    }
    Plan::done(folder, index)?;
    writeln!(stdout, "task {index} of {} is done", plan.tasks)?;
    Ok(Exit::Success)
}

fn whole(cli: &Cli, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    match &cli.command {
        None => super::bench(&cli.run, stdout),
        #[cfg(feature = "train")]
        Some(Command::Study(args)) => super::study(args, stdout),
        Some(Command::Map(args)) => super::map(args, stdout),
        _ => Err(SweepError::Unsplit.into()),
    }
}

/// The planned command line, with files in the place of names.
fn parsed(command: &[String]) -> Result<Cli, BenchError> {
    use clap::Parser;
    let line = std::iter::once("bench").chain(command.iter().map(String::as_str));
    let mut cli =
        Cli::try_parse_from(line).map_err(|error| SweepError::Command { error: error.to_string() })?;
    source::find(&mut cli)?;
    match &cli.command {
        None | Some(Command::Map(_) | Command::Study(_)) => Ok(cli),
        Some(_) => Err(SweepError::Unsplit.into()),
    }
}
