//! Why a scene file, or a study, is refused.

use super::MAX_BYTES;
use crate::exit::{Ends, Exit};
use std::path::PathBuf;
use thiserror::Error;
use vantage_sim::checked::SceneError;

/// Why a scene file, or a study, is refused.
#[derive(Debug, Error)]
pub enum SceneFileError {
    /// It cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is far larger than any scene or study.
    #[error(
        "{} is larger than {MAX_BYTES} bytes: a scene or a study is a page of YAML, is this the right file?",
        path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// It is not text.
    #[error("{} is not UTF-8 text (byte {offset})", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// Offset of the first byte that is not.
        offset: usize,
    },
    /// It is neither scene nor study: the message holds line, column and a snippet for each reason.
    #[error("{} is not valid:\n{message}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// All reasons.
        message: String,
    },
    /// It breaks a rule of the simulated part, or names a mesh that cannot be used.
    #[error("{} is not valid: {source}", path.display())]
    Rules {
        /// The file.
        path: PathBuf,
        /// The rule.
        source: SceneError,
    },
    /// Its episodes were recorded, and what is asked is of a simulated world.
    #[error(
        "{}: evaluation.episodes: its episodes were recorded, and this command simulates; leave the field out, or name another scene",
        path.display()
    )]
    Recorded {
        /// The file.
        path: PathBuf,
    },
}

impl Ends for SceneFileError {
    fn exit(&self) -> Exit {
        match self {
            Self::Rules { source: SceneError::Mesh(error), .. } => error.exit(),
            _ => Exit::BadInput,
        }
    }
}
