//! Writing a file whole or not at all.

use crate::train::error::TrainError;
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Writes through a temporary file beside it, synced before it takes the name.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), TrainError> {
    let failed = |error: std::io::Error| unwritable(path, &error);
    let mut name = path.as_os_str().to_owned();
    name.push(".tmp");
    let temporary = Path::new(&name);
    let mut file = File::create(temporary).map_err(failed)?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(failed)?;
    std::fs::rename(temporary, path).map_err(failed)
}

/// A file that cannot be written, for whatever reason.
pub(crate) fn unwritable(path: &Path, error: &dyn std::fmt::Display) -> TrainError {
    TrainError::Write { path: path.to_owned(), reason: error.to_string() }
}
