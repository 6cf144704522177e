//! Reading a file of a model folder: nothing but a regular one, and no more of it than a limit.

use crate::error::ModelError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The bytes of a file.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, ModelError> {
    let failed = |source| ModelError::Read { path: path.to_owned(), source };
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(ModelError::NotAFile { path: path.to_owned() });
    }
    // One byte more than the limit, since a file may grow after it was measured.
    let mut content = Vec::new();
    if metadata.len() <= limit {
        File::open(path).and_then(|file| file.take(limit + 1).read_to_end(&mut content)).map_err(failed)?;
    }
    let bytes = metadata.len().max(content.len() as u64);
    if bytes > limit {
        Err(ModelError::TooLarge { path: path.to_owned(), bytes, limit })
    } else {
        Ok(content)
    }
}
