//! The split of views that a command is given.

use crate::command::error::BenchError;
use crate::command::folder::FolderError;
use std::path::Path;
use vantage_dataset::Split;
use vantage_dataset::store::{Content, read_manifest};

/// Refuses a view set of another split than the one that `named_by` takes.
pub fn check_split(folder: &Path, named_by: &str, expected: Split) -> Result<(), BenchError> {
    match read_manifest(folder)?.content {
        Content::Views { split: got } if got != expected => {
            let (folder, named_by) = (folder.to_owned(), named_by.to_owned());
            Err(FolderError::OtherSplit { folder, named_by, got, expected }.into())
        }
        // What is no view set is told by what reads it.
        Content::Views { .. } | Content::Episode { .. } => Ok(()),
    }
}
