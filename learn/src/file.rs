//! Reading a file of a model folder: nothing but a regular one, and no more of it than a limit.

use crate::error::ModelError;
use std::io::ErrorKind;
use std::path::Path;
use vantage_dataset::store::read_regular;

/// The bytes of a file.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, ModelError> {
    read_regular(path, limit).map_err(|source| {
        let path = path.to_owned();
        match source.kind() {
            ErrorKind::InvalidInput => ModelError::NotAFile { path },
            ErrorKind::FileTooLarge => ModelError::TooLarge { path, limit },
            _ => ModelError::Read { path, source },
        }
    })
}
