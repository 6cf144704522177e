//! Why a dataset is not written.

use crate::exit::Ends;
use std::path::PathBuf;
use thiserror::Error;

/// Why a dataset is not written.
#[derive(Debug, Error)]
pub enum DatasetError {
    /// A folder holds a dataset of another scene, split, renderer or program.
    #[error("{} holds a dataset of another {differs}; choose another folder with --out", folder.display())]
    OtherData {
        folder: PathBuf,
        /// In what it is another.
        differs: String,
    },
    /// A format that this scene's images cannot be written in.
    #[error("--format {format}: {reason}; choose another format or scene")]
    Unsuitable { format: &'static str, reason: String },
}

impl Ends for DatasetError {}
