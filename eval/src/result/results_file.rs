//! Results: the file that a run leaves, that is committed as a baseline, and that a later run is compared with.
//!
//! It holds scores and what they are scores of, and nothing of the host or the clock, so that equal inputs give equal
//! bytes; those facts are in the [manifest](crate::result::manifest).

use crate::exit::{Ends, Exit};
use crate::result::table::Table;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::store::read_regular;

/// Version of the file's format.
pub const FORMAT: u32 = 1;
/// Name of the file.
pub const FILE_NAME: &str = "results.json";
/// Largest file, bytes.
const LARGEST_FILE: u64 = 256 << 20;

/// The tables of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Results {
    format: u32,
    /// The scene's name.
    pub scene: String,
    /// Hash of the scene as read: see [`crate::scene_file::hash`].
    pub scene_hash: String,
    /// The tables.
    pub tables: Vec<Table>,
}

/// Why a results file cannot be used.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// There is none.
    #[error(
        "no results at {}: the committed ones are in a checkout of Vantage, in its folder `results`; run there, or name a folder \
         by --baseline DIR, such as one that `bench SCENE --out DIR` wrote",
        path.display()
    )]
    Missing {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// It cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not what was written.
    #[error("{} is no results file: {source}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: serde_json::Error,
    },
    /// It was written by another version.
    #[error("{} has format {found}, this version reads {FORMAT}: write the results anew", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
}

impl Ends for ResultsError {
    fn exit(&self) -> Exit {
        match self {
            Self::Missing { .. } => Exit::BadInput,
            Self::Unreadable { .. } | Self::Invalid { .. } | Self::Format { .. } => Exit::StoredDataInvalid,
        }
    }
}

#[derive(Deserialize)]
struct Version {
    format: u32,
}

impl Results {
    /// Results of a scene.
    pub fn new(scene: &str, scene_hash: &str, tables: Vec<Table>) -> Self {
        Self { format: FORMAT, scene: scene.to_owned(), scene_hash: scene_hash.to_owned(), tables }
    }

    /// The table of this name.
    pub fn table(&self, name: &str) -> Option<&Table> {
        self.tables.iter().find(|table| table.name() == name)
    }

    /// The file's text.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads the results file in `folder`.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let path = folder.join(FILE_NAME);
        let text = match read_regular(&path, LARGEST_FILE) {
            Ok(text) => text,
            Err(source) if source.kind() == std::io::ErrorKind::NotFound => {
                return Err(ResultsError::Missing { path });
            }
            Err(source) => return Err(ResultsError::Unreadable { path, source }),
        };
        let invalid = |source| ResultsError::Invalid { path: path.clone(), source };
        let found = serde_json::from_slice::<Version>(&text).map_err(invalid)?.format;
        if found != FORMAT {
            return Err(ResultsError::Format { path, found });
        }
        serde_json::from_slice(&text).map_err(invalid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::{runs, table};

    #[test]
    fn reading_inverts_writing_and_equal_inputs_give_equal_bytes() {
        let results = || Results::new("tabletop", "abc", vec![table(runs()).unwrap()]);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE_NAME), results().to_json().unwrap()).unwrap();
        assert_eq!(Results::read(folder.path()).unwrap(), results());
        assert_eq!(Results::read(folder.path()).unwrap().to_json().unwrap(), results().to_json().unwrap());
    }

    #[test]
    fn missing_broken_and_newer_files_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(Results::read(folder.path()), Err(ResultsError::Missing { .. })));
        let json = Results::new("tabletop", "abc", vec![table(runs()).unwrap()]).to_json().unwrap();
        let write = |text: &str| std::fs::write(folder.path().join(FILE_NAME), text).unwrap();
        write(&json[..json.len() / 2]);
        assert!(matches!(Results::read(folder.path()), Err(ResultsError::Invalid { .. })));
        write(&json.replacen("\"format\": 1", "\"format\": 2", 1));
        assert!(matches!(Results::read(folder.path()), Err(ResultsError::Format { found: 2, .. })));
        write(&json.replacen("\"scene\"", "\"scenery\"", 1));
        assert!(matches!(Results::read(folder.path()), Err(ResultsError::Invalid { .. })));
    }
}
