//! Why a scene is not drawn.

use crate::exit::{Ends, Exit};
use std::path::PathBuf;
use thiserror::Error;

/// Why a scene is not drawn.
#[derive(Debug, Error)]
pub enum LookError {
    /// A picture that would not be one.
    #[error("--out {}: expected the name of a PNG file", path.display())]
    NoPicture {
        /// What was asked for.
        path: PathBuf,
    },
    /// A recording is asked for, of a program that cannot write one.
    #[cfg(not(feature = "rerun"))]
    #[error(
        "this program was built without Rerun: build it with `cargo build --release -p vantage-eval --features rerun`, or \
         leave --rerun out"
    )]
    CannotRecord,
}

impl Ends for LookError {
    fn exit(&self) -> Exit {
        match self {
            Self::NoPicture { .. } => Exit::BadInput,
            #[cfg(not(feature = "rerun"))]
            Self::CannotRecord => Exit::MissingCapability,
        }
    }
}
