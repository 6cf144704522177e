//! JSON files, and the words in them that Python writes and JSON has not.

use crate::import::{FETCH_AGAIN, ImportError, read_file};
use serde::de::DeserializeOwned;
use std::path::Path;

/// What Python's `json.dump` makes of floats that are no numbers.
const NO_NUMBERS: [&str; 2] = ["NaN", "Infinity"];

/// What a file of at most `limit` bytes holds.
///
/// # Errors
///
/// A file that cannot be read, or that holds something else.
pub(super) fn read<T: DeserializeOwned>(path: &Path, limit: u64, expected: &str) -> Result<T, ImportError> {
    let bytes = read_file(path, limit)?;
    serde_json::from_slice(&bytes).map_err(|error| match no_number(&bytes, &error) {
        Some(word) => {
            let field = format!("line {}, column {}", error.line(), error.column());
            let expected = "a number: JSON has no NaN and no Infinity";
            ImportError::invalid(path, field, word, expected, "replace it by a number, or remove its entry")
        }
        None => ImportError::invalid(path, "JSON", error, expected, FETCH_AGAIN),
    })
}

/// The word that stands where a number should.
fn no_number(bytes: &[u8], error: &serde_json::Error) -> Option<&'static str> {
    let line = bytes.split(|byte| *byte == b'\n').nth(error.line().checked_sub(1)?)?;
    let rest = line.get(error.column().checked_sub(1)?..)?;
    NO_NUMBERS.into_iter().find(|word| rest.starts_with(word.as_bytes()))
}
