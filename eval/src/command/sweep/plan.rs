//! The plan of a sweep: a command and its tasks, in a folder that all machines see.

use super::error::SweepError;
use crate::command::cli::{Cli, Command};
use crate::command::error::BenchError;
use crate::result::output_folder::OutputFolder;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use vantage_dataset::store::read_regular;

const FILE: &str = "plan.json";
/// Folder of the marks of tasks that are done.
const DONE: &str = "done";
const VERSION: u32 = 1;
const LARGEST: u64 = 1 << 20;

/// What tells a process which task it is, and the number of the first.
pub(super) const VARIABLES: [(&str, usize); 4] =
    [("SLURM_ARRAY_TASK_ID", 0), ("HQ_TASK_ID", 0), ("JOB_COMPLETION_INDEX", 0), ("PARALLEL_SEQ", 1)];

/// A command in parts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Plan {
    version: u32,
    /// How many.
    pub(super) tasks: usize,
    /// The words after `bench`.
    pub(super) command: Vec<String>,
    /// Hash of the scene, study or map as text.
    file_hash: String,
}

impl Plan {
    pub(super) fn new(tasks: usize, command: &[String], cli: &Cli) -> Result<Self, SweepError> {
        Ok(Self { version: VERSION, tasks, command: command.to_vec(), file_hash: hash(file(cli))? })
    }

    /// Writes it; the same plan again changes nothing.
    pub(super) fn write(&self, folder: &Path) -> Result<(), BenchError> {
        if folder.join(FILE).exists() {
            let same = Self::read(folder)? == *self;
            return if same { Ok(()) } else { Err(SweepError::Planned { folder: folder.to_owned() }.into()) };
        }
        if folder.join(DONE).exists() {
            return Err(SweepError::Planned { folder: folder.to_owned() }.into());
        }
        Ok(OutputFolder::probe(folder)?
            .write(FILE, (serde_json::to_string_pretty(self)? + "\n").as_bytes())?)
    }

    pub(super) fn read(folder: &Path) -> Result<Self, SweepError> {
        let path = folder.join(FILE);
        let failed = |reason: String| SweepError::Plan { path: path.clone(), reason };
        let bytes = read_regular(&path, LARGEST).map_err(|error| failed(error.to_string()))?;
        let plan: Self = serde_json::from_slice(&bytes).map_err(|error| failed(error.to_string()))?;
        if plan.version != VERSION || plan.tasks == 0 {
            return Err(failed(format!("version {} with {} tasks", plan.version, plan.tasks)));
        }
        Ok(plan)
    }

    /// Refuses a file that has changed since.
    pub(super) fn check(&self, cli: &Cli) -> Result<(), SweepError> {
        let path = file(cli);
        if hash(path)? == self.file_hash {
            Ok(())
        } else {
            Err(SweepError::Changed { path: path.to_owned() })
        }
    }

    pub(super) fn is_done(folder: &Path, index: usize) -> bool {
        folder.join(marker(index)).is_file()
    }

    pub(super) fn done(folder: &Path, index: usize) -> Result<(), BenchError> {
        Ok(OutputFolder::probe(folder)?.write(marker(index), b"done\n")?)
    }
}

fn marker(index: usize) -> PathBuf {
    PathBuf::from(DONE).join(index.to_string())
}

fn file(cli: &Cli) -> &Path {
    match &cli.command {
        Some(Command::Study(args)) => &args.study,
        Some(Command::Map(args)) => &args.map,
        _ => cli.run.scene.as_deref().unwrap_or(Path::new("")),
    }
}

fn hash(path: &Path) -> Result<String, SweepError> {
    let text = read_regular(path, LARGEST)
        .map_err(|error| SweepError::Unreadable { path: path.to_owned(), reason: error.to_string() })?;
    Ok(blake3::hash(&text).to_hex().to_string())
}

/// The task that Slurm, HyperQueue, Kubernetes or GNU parallel says this process is.
pub(super) fn index_of_environment() -> Result<usize, SweepError> {
    let told = VARIABLES.into_iter().filter_map(|(name, first)| {
        let text = std::env::var(name).ok()?;
        let index = text.parse::<usize>().ok().and_then(|number| number.checked_sub(first));
        Some(index.ok_or(SweepError::NoNumber { name, text }))
    });
    let told = told.collect::<Result<Vec<usize>, _>>()?;
    match told[..] {
        [] => Err(SweepError::NoIndex),
        [first, ..] if told.iter().all(|other| *other == first) => Ok(first),
        _ => Err(SweepError::Ambiguous),
    }
}
