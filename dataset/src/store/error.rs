//! What can go wrong with stored data: where, what was found, what was expected, and the remedy.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// How many characters of a foreign file go into a message.
const SHOWN: usize = 200;

/// One datum that is not as the format says.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}, {field}: got {got}, expected {expected}", .line.map(|l| format!(", line {l}")).unwrap_or_default())]
pub struct Fault {
    /// The file, relative to its folder.
    pub file: String,
    /// Line of a text file, counted from 1.
    pub line: Option<u64>,
    /// The column or field.
    pub field: String,
    /// What it holds.
    pub got: String,
    /// What the format asks for.
    pub expected: String,
}

impl Fault {
    /// A fault; of what was got the first 200 characters are kept.
    pub fn new(
        file: &str,
        line: Option<u64>,
        field: impl Into<String>,
        got: impl ToString,
        expected: impl Into<String>,
    ) -> Self {
        let file = file.to_owned();
        let got = got.to_string();
        let got = got.char_indices().nth(SHOWN).map_or(got.clone(), |(end, _)| format!("{}...", &got[..end]));
        Self { file, line, field: field.into(), got, expected: expected.into() }
    }
}

/// Why stored data could not be written or read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum StoreError {
    /// The disk is full, or the place cannot be written.
    #[error("cannot write {}: {source}; {}", path.display(), write_remedy(source.kind()))]
    Write {
        /// The file or folder.
        path: PathBuf,
        source: io::Error,
    },
    /// The system could not read a file that is there.
    #[error("cannot read {}: {source}; check that it exists and may be read", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        source: io::Error,
    },
    /// There is no manifest, which is written last.
    #[error(
        "{} holds no manifest.json: it was never finished, or is no dataset folder; write it again",
        folder.display()
    )]
    Unfinished { folder: PathBuf },
    /// A later version of the program wrote this.
    #[error(
        "{} has format {found}, and this version reads up to {supported}; \
         use the version that wrote it, or another folder (nothing was changed)",
        path.display()
    )]
    Newer { path: PathBuf, found: u64, supported: u32 },
    /// A file is not the one that was written: lost, cut short, or changed.
    #[error("{} is damaged: got {got}, expected {expected}; write its folder again", path.display())]
    Damaged { path: PathBuf, got: String, expected: String },
    /// A file holds what the format forbids.
    #[error("{}/{fault}; write the folder again, or mend the program that wrote it", folder.display())]
    Invalid { folder: PathBuf, fault: Box<Fault> },
    /// What was to be written breaks the format; nothing was written.
    #[error("refused to write {}/{fault}; mend the program that made it", folder.display())]
    Unfit { folder: PathBuf, fault: Box<Fault> },
    /// The folder holds what no version of this program wrote; it was left as it is.
    #[error("{} holds other files than a dataset written here; choose an empty or a new folder", folder.display())]
    Foreign { folder: PathBuf },
    /// An episode in place of a view set, or the other way round.
    #[error("{} holds {got}: name a folder that holds {expected}", folder.display())]
    OtherKind { folder: PathBuf, got: &'static str, expected: &'static str },
    /// A dataset that was begun, or written, with other options or from other inputs.
    #[error(
        "{}/{fault}; run with those options again to go on, or choose another folder",
        folder.display()
    )]
    Differs {
        folder: PathBuf,
        /// What differs: what was asked for now, and what the dataset was begun with.
        fault: Box<Fault>,
    },
    /// The inputs of a stage cannot be put into a cache key.
    #[error("no cache key for stage {stage:?}: {reason}; mend the program that names the stage")]
    Key { stage: String, reason: String },
}

/// What has to change for a store to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreErrorKind {
    /// The choice of folder or options.
    Choice,
    /// Stored data, which are not what was written.
    Stored,
    /// The disk or the rights on it.
    Unwritable,
    /// The program that stores.
    Bug,
}

impl StoreError {
    /// What has to change for it to go.
    pub fn kind(&self) -> StoreErrorKind {
        match self {
            Self::Foreign { .. } | Self::OtherKind { .. } | Self::Differs { .. } => StoreErrorKind::Choice,
            Self::Write { .. } => StoreErrorKind::Unwritable,
            Self::Read { .. }
            | Self::Unfinished { .. }
            | Self::Newer { .. }
            | Self::Damaged { .. }
            | Self::Invalid { .. } => StoreErrorKind::Stored,
            Self::Unfit { .. } | Self::Key { .. } => StoreErrorKind::Bug,
        }
    }

    /// What was found, without the remedy: for programs that mend it themselves.
    pub fn finding(&self) -> String {
        match self {
            Self::Damaged { path, got, expected } => {
                format!("{} is damaged: got {got}, expected {expected}", path.display())
            }
            Self::Invalid { folder, fault } => format!("{}/{fault}", folder.display()),
            other => other.to_string(),
        }
    }

    /// That `path` could not be written.
    pub fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Write { path, source }
    }

    /// That `path` could not be read.
    pub fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Read { path, source }
    }

    /// That stored data in `folder` are not as the format says.
    pub fn invalid(folder: &Path) -> impl FnOnce(Fault) -> Self {
        let folder = folder.to_owned();
        |fault| Self::Invalid { folder, fault: Box::new(fault) }
    }

    /// That what was to be written into `folder` breaks the format.
    pub fn unfit(folder: &Path) -> impl FnOnce(Fault) -> Self {
        let folder = folder.to_owned();
        |fault| Self::Unfit { folder, fault: Box::new(fault) }
    }
}

fn write_remedy(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "free some space and run again: what was finished is kept"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to"
        }
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => "a file is in the way: choose another folder",
        _ => "check the disk, or choose another folder",
    }
}
