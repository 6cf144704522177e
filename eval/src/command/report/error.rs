//! Why there is no report.

use crate::exit::{Ends, Exit};
use std::path::PathBuf;
use thiserror::Error;

/// Why there is no report.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A folder without a result.
    #[error(
        "no results in {}: name a folder that `bench SCENE` or `bench study` wrote, or one that holds `scenes` or `studies`",
        folder.display()
    )]
    Nothing {
        /// The folder.
        folder: PathBuf,
    },
    /// The report's place is a folder.
    #[error("{} is no file name: say which file gets the report, as --out report.html", path.display())]
    NoFile {
        /// What was named.
        path: PathBuf,
    },
    /// A manifest that is not there or no JSON.
    #[error("{}: {reason}; run again what wrote these results", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl Ends for ReportError {
    fn exit(&self) -> Exit {
        match self {
            Self::Nothing { .. } | Self::NoFile { .. } => Exit::BadInput,
            Self::Manifest { .. } => Exit::StoredDataInvalid,
        }
    }
}
