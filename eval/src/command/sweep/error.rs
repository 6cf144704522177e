//! Why a sweep does not go on.

use crate::exit::{Ends, Exit};
use std::path::PathBuf;
use thiserror::Error;

/// Why a sweep does not go on.
#[derive(Debug, Error)]
pub enum SweepError {
    /// The command line that is to be split is none.
    #[error("the command to be split is no command of bench: {error}")]
    Command {
        /// What the command line says.
        error: String,
    },
    /// Another command than those that have parts.
    #[error(
        "only `SCENE`, `study` and `map` are split into tasks, as in `bench sweep plan --tasks 8 --out DIR -- sparse_loop --seeds 40`"
    )]
    Unsplit,
    /// No plan, or one of another version.
    #[error("{}: {reason}; write it by `bench sweep plan`", path.display())]
    Plan {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The scene, the study or the map cannot be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A variable that should say which task holds no number.
    #[error("{name} is {text:?}, which is no number of a task: give --index N")]
    NoNumber {
        /// The variable.
        name: &'static str,
        /// What it holds.
        text: String,
    },
    /// Two variables say two tasks.
    #[error("several variables say which task this is, and not the same one: give --index N")]
    Ambiguous,
    /// The planned file is not as it was.
    #[error("{} is not as it was planned: plan anew", path.display())]
    Changed {
        /// The scene, study or map.
        path: PathBuf,
    },
    /// A plan lies there already.
    #[error("{} holds another plan: choose another folder with --out", folder.display())]
    Planned {
        /// The folder.
        folder: PathBuf,
    },
    /// A task that the plan does not have.
    #[error("there is no task {index}: the plan has {tasks}, from 0 on")]
    NoTask {
        /// The number that was asked for.
        index: usize,
        /// How many there are.
        tasks: usize,
    },
    /// Nothing says which task.
    #[error(
        "which task? Give --index N, or run under Slurm, HyperQueue, Kubernetes or GNU parallel, which say it by {}",
        super::plan::VARIABLES.map(|(name, _)| name).join(", ")
    )]
    NoIndex,
    /// Tasks that are not done.
    #[error(
        "of the plan in {} these tasks are not done: {}; run each by `bench sweep run {} --index N`",
        folder.display(),
        missing.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        folder.display()
    )]
    Missing {
        /// The plan's folder.
        folder: PathBuf,
        /// Their numbers.
        missing: Vec<usize>,
    },
}

impl Ends for SweepError {
    fn exit(&self) -> Exit {
        match self {
            Self::Missing { .. } => Exit::NothingEvaluated,
            _ => Exit::BadInput,
        }
    }
}
