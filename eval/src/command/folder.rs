//! Folders that a command is given.

use crate::exit::Ends;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A folder that is not what a command needs.
#[derive(Debug, Error)]
pub enum FolderError {
    /// One that is to be read is not there.
    #[error("there is no folder {}", folder.display())]
    Missing { folder: PathBuf },
    /// One that is to be written to holds something else.
    #[error(
        "{} already holds something else: nothing was changed; choose a new or empty folder with --out",
        folder.display()
    )]
    NotOurs { folder: PathBuf },
}

impl Ends for FolderError {}

/// Refuses a folder that is not there.
pub fn is_there(folder: &Path) -> Result<(), FolderError> {
    if folder.is_dir() { Ok(()) } else { Err(FolderError::Missing { folder: folder.to_owned() }) }
}
