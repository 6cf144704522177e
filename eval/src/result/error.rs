//! Why results are not saved.

use super::output_folder::OutputError;
use crate::exit::{Ends, Exit};
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
    /// A value of ours that JSON cannot hold.
    #[error("cannot write as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl Ends for SaveError {
    fn exit(&self) -> Exit {
        match self {
            Self::Output(error) => error.exit(),
            Self::Store(error) => error.exit(),
            Self::Json(error) => error.exit(),
        }
    }
}
