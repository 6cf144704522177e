//! Why results are not saved.

use super::kind::ResultKind;
use super::output_folder::OutputError;
use std::path::PathBuf;
use thiserror::Error;
use vantage_dataset::store::StoreError;

/// Why results are not saved.
#[derive(Debug, Error)]
pub enum SaveError {
    /// See [`OutputError`].
    #[error(transparent)]
    Output(#[from] OutputError),
    /// See [`StoreError`].
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Results would be written over those of something else that has the same name.
    #[error(
        "{} holds the results of a {of} of the same name: nothing was changed; name this one otherwise, or choose another folder with --out",
        folder.display()
    )]
    OtherResults {
        /// The folder.
        folder: PathBuf,
        /// What they are of.
        of: ResultKind,
    },
    /// A value of ours that JSON cannot hold.
    #[error("cannot write as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A table that CSV cannot hold.
    #[error("cannot write as CSV: {0}")]
    Csv(#[from] csv::Error),
}
