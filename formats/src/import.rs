//! What reading a dataset of others says: what was left out, and what stopped it.

use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use vantage_dataset::store::read_regular;

/// How many characters of a foreign file go into a message.
const SHOWN: usize = 200;

pub(crate) const FETCH_AGAIN: &str = "fetch the file again";

/// What was read, and what was not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ImportReport {
    /// Views, or detections, that were made.
    pub views: usize,
    /// What was left out, in the order of reading.
    pub skipped: Vec<Skipped>,
}

/// Something that a dataset lacks, or that could not be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// The file that it is about, which may be one that is not there.
    pub file: PathBuf,
    /// Why it was left out.
    pub reason: String,
}

impl std::fmt::Display for Skipped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Reasons that are errors of reading name the file themselves.
        let file = self.file.display().to_string();
        if self.reason.contains(&file) {
            f.write_str(&self.reason)
        } else {
            write!(f, "{file}: {}", self.reason)
        }
    }
}

impl ImportReport {
    pub(crate) fn skip(&mut self, file: impl Into<PathBuf>, reason: impl ToString) {
        self.skipped.push(Skipped { file: file.into(), reason: reason.to_string() });
    }
}

/// Why a dataset of others could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The system could not read a file.
    #[error("cannot read {}: {source}; check that it exists and may be read", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file does not hold what its layout says.
    #[error(transparent)]
    Invalid(Box<Problem>),
}

/// One datum that is not as the layout says.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}, {field}: got {got}, expected {expected}; {remedy}", file.display())]
pub struct Problem {
    /// The file.
    pub file: PathBuf,
    /// The field, dataset or line.
    pub field: String,
    /// What it holds.
    pub got: String,
    /// What the layout asks for.
    pub expected: String,
    /// What to do.
    pub remedy: &'static str,
}

impl ImportError {
    pub(crate) fn invalid(
        file: &Path,
        field: impl Into<String>,
        got: impl Display,
        expected: impl Into<String>,
        remedy: &'static str,
    ) -> Self {
        let shown = |letter: char| if letter.is_control() { char::REPLACEMENT_CHARACTER } else { letter };
        let got = got.to_string().chars().map(shown).take(SHOWN).collect();
        let problem =
            Problem { file: file.to_owned(), field: field.into(), got, expected: expected.into(), remedy };
        Self::Invalid(Box::new(problem))
    }

    pub(crate) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Read { path, source }
    }

    /// Whether the file is not there, rather than unfit.
    pub(crate) fn is_absence(&self) -> bool {
        matches!(self, Self::Read { source, .. } if source.kind() == ErrorKind::NotFound)
    }
}

/// The bytes of a regular file of at most `limit` bytes.
pub(crate) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ImportError> {
    read_regular(path, limit).map_err(|error| match error.kind() {
        ErrorKind::FileTooLarge => {
            let expected = format!("at most {limit} bytes");
            ImportError::invalid(path, "size", "more", expected, "check that it is the right file")
        }
        _ => ImportError::read(path)(error),
    })
}
