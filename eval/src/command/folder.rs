//! Folders that a command is given.

use crate::exit::Ends;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::Split;

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
    /// A view set of another split than the one it would be used for.
    #[error(
        "{}, which {named_by} names, holds views of split {}, expected {}: import them with `--split {}`, or name another folder",
        folder.display(), got.name(), expected.name(), expected.name()
    )]
    OtherSplit { folder: PathBuf, named_by: String, got: Split, expected: Split },
}

impl Ends for FolderError {}

/// Refuses a folder that is not there.
pub fn is_there(folder: &Path) -> Result<(), FolderError> {
    if folder.is_dir() { Ok(()) } else { Err(FolderError::Missing { folder: folder.to_owned() }) }
}
