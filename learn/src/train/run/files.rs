//! Writing a file whole or not at all.

use crate::train::error::TrainError;
use std::path::Path;
use vantage_dataset::store::write_atomically;

/// [`write_atomically`], with the file named where it fails.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), TrainError> {
    write_atomically(path, bytes).map_err(|error| unwritable(path, &error))
}

/// A file that cannot be written, for whatever reason.
pub(crate) fn unwritable(path: &Path, error: &dyn std::fmt::Display) -> TrainError {
    TrainError::Write { path: path.to_owned(), reason: error.to_string() }
}
