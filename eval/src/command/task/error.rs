//! Why a task is not written, or a submission not scored.

use crate::exit::{Ends, Exit};
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a task is not written, or a submission not scored.
#[derive(Debug, Error)]
pub enum TaskError {
    /// The truth would be published.
    #[error("--truth {} lies in --out, which is published, or --out in it; choose a folder beside it", path.display())]
    Inside {
        /// The folder of the truth.
        path: PathBuf,
    },
    /// A folder holds something else.
    #[error("{} is not of this task; choose another folder, or remove it", path.display())]
    Taken {
        /// The folder.
        path: PathBuf,
    },
    /// A secret that everybody guesses.
    #[error(
        "--secret {}: {found} different characters of {length}, expected at least 8 of 16: whoever guesses it can make the truth anew; \
         `head -c 32 /dev/urandom | base64 > FILE` makes one",
        path.display()
    )]
    Secret {
        /// The file.
        path: PathBuf,
        /// Its length.
        length: usize,
        /// How many characters differ.
        found: usize,
    },
    /// No robot drives in the scene.
    #[error("{}: no robot drives in it; choose a scene with a path", scene.display())]
    Undriven {
        /// The scene.
        scene: PathBuf,
    },
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file that is not what was written.
    #[error("{}: {source}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// Of another version.
    #[error("{}: format {found}, and this program reads format 1; use the program that wrote it", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
    /// A truth that is not the one that was published with the task.
    #[error("{} is not the truth of the task in {}: its hash is {found}, the task's {expected}", truth.display(), task.display())]
    OtherTruth {
        /// The folder of the truth.
        truth: PathBuf,
        /// The folder of the task.
        task: PathBuf,
        /// Its hash.
        found: String,
        /// What was published.
        expected: String,
    },
    /// An episode that is not the one that was sealed.
    #[error("{}: the episode is not the one that was sealed", path.display())]
    OtherEpisode {
        /// Its folder.
        path: PathBuf,
    },
    /// A submission that says nothing.
    #[error("{}: {reason}", path.display())]
    Submission {
        /// The folder, or the file in it.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl Ends for TaskError {
    fn exit(&self) -> Exit {
        match self {
            Self::OtherEpisode { .. } | Self::OtherTruth { .. } => Exit::StoredDataInvalid,
            _ => Exit::BadInput,
        }
    }
}
