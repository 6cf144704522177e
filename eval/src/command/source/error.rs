//! What is no scene, no study and no map, and what may have been meant.

use crate::exit::Ends;
use crate::scene_file::FileKind;
use std::path::PathBuf;
use thiserror::Error;

/// What is given in place of a scene, a study or a map.
#[derive(Debug, Error)]
pub enum SourceError {
    /// A word that is neither a command nor a scene.
    #[error("there is no command and no scene `{word}`{} (`bench --help` lists the commands, `bench list` the scenes)", meant.hint())]
    NoCommand {
        word: String,
        /// What may have been meant.
        meant: Meant,
    },
    /// A name that nothing has.
    #[error("there is no {kind} `{name}`{} (`bench list` names those that come with the program)", meant.hint())]
    NoName {
        /// What was looked for.
        kind: FileKind,
        name: String,
        /// What may have been meant.
        meant: Meant,
    },
    /// A file that is not there.
    #[error("there is no file {}{}", path.display(), meant.hint())]
    NoFile {
        /// Where it was looked for.
        path: PathBuf,
        /// What may have been meant.
        meant: Meant,
    },
    /// A folder.
    #[error("{} is a folder, expected one {kind}{}", folder.display(), listed(*kind, files))]
    Folder {
        folder: PathBuf,
        /// What was looked for.
        kind: FileKind,
        /// What it holds of that.
        files: Vec<PathBuf>,
    },
    /// A file of another kind.
    #[error("{} is a {found}, expected a {expected}: `{} {}` runs it", given.display(), found.command(), given.display())]
    Other {
        /// What was given.
        given: PathBuf,
        /// What it is.
        found: FileKind,
        /// What was looked for.
        expected: FileKind,
    },
}

impl Ends for SourceError {}

/// What may have been meant, if anything comes near.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Meant(pub(super) Option<String>);

impl Meant {
    /// The word among `known` that is nearest to `word`, and what to say of it.
    pub(super) fn nearest(word: &str, known: impl IntoIterator<Item = (String, String)>) -> Self {
        let distance = |other: &str| strsim::damerau_levenshtein(word, other);
        let near = known.into_iter().map(|(other, say)| (distance(&other), say));
        let near = near.filter(|(distance, _)| *distance <= (word.len() / 3).max(1));
        Self(near.min().map(|(_, say)| say))
    }

    fn hint(&self) -> String {
        self.0.as_ref().map(|meant| format!("; did you mean {meant}?")).unwrap_or_default()
    }
}

fn listed(kind: FileKind, files: &[PathBuf]) -> String {
    let names: Vec<String> = files.iter().map(|file| format!("\n  {}", file.display())).collect();
    if names.is_empty() {
        return format!(", and it holds no {kind}");
    }
    format!(", such as one of:{}", names.concat())
}
