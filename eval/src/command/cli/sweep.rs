//! Options of `bench sweep`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// `bench sweep`: numbered tasks.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct SweepArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: SweepCommand,
}

/// What to do with a sweep.
#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum SweepCommand {
    /// Writes a plan: a command in so many tasks.
    Plan {
        /// How many tasks.
        #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=100_000))]
        tasks: usize,
        /// Folder that gets the plan, and a mark for each task that is done; all machines have to see it, as they do the cache.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// The words after `bench`: a scene, `study STUDY` or `map MAP`, with options.
        #[arg(last = true, required = true, value_name = "COMMAND")]
        command: Vec<String>,
    },
    /// Does a task, unless it is done.
    Run {
        /// The plan's folder.
        #[arg(value_name = "DIR")]
        plan: PathBuf,
        /// Which task, from 0 on; where it is not given, the one that Slurm, HyperQueue, Kubernetes or GNU parallel says.
        #[arg(long, value_name = "N")]
        index: Option<usize>,
    },
    /// Runs the command whose tasks are all done; names those that are not.
    Merge {
        /// The plan's folder.
        #[arg(value_name = "DIR")]
        plan: PathBuf,
    },
    /// Prints a batch script for `sbatch`.
    Slurm {
        /// The plan's folder.
        #[arg(value_name = "DIR")]
        plan: PathBuf,
    },
    /// Prints an indexed job for `kubectl apply`.
    Kubernetes {
        /// The plan's folder, as the job sees it from the volume's root.
        #[arg(value_name = "DIR")]
        plan: PathBuf,
        /// The image that has `bench`.
        #[arg(long, value_name = "IMAGE")]
        image: String,
        /// The claim of a volume with plan, files and cache.
        #[arg(long, value_name = "NAME")]
        claim: String,
    },
}
