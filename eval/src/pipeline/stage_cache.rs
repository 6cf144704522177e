//! The cache of the stages: what one has made is not made again.

use super::StageError;
use crate::progress::Progress;
use crate::result::output_folder::OutputError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::time::Duration;
use vantage_dataset::store::{Cache, Entry, Key, Origin, read_regular};

/// Work of a killed run that nobody took up is removed after this time.
const ABANDONED_AFTER: Duration = Duration::from_secs(7 * 24 * 3600);

/// More bytes no stored answers have.
const LARGEST_FILE: u64 = 1 << 30;

/// A cache that tells of waiting and of damage.
pub struct StageCache {
    cache: Cache,
    folder: PathBuf,
    progress: Progress,
}

impl StageCache {
    /// Opens the cache in a folder.
    pub fn open(folder: &Path, progress: &Progress) -> Result<Self, StageError> {
        let waiting = progress.clone();
        let cache = Cache::open(folder)?.on_wait(move |holder| waiting.note(&holder.to_string()));
        cache.remove_abandoned_work(ABANDONED_AFTER)?;
        Ok(Self { cache, folder: folder.to_owned(), progress: progress.clone() })
    }

    /// Where it lies.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The entry of a key, built where the cache has none; a damaged one is set aside and told of.
    pub fn entry(
        &self,
        key: &Key,
        build: impl FnOnce(&Path) -> Result<(), StageError>,
    ) -> Result<Entry, StageError> {
        let entry = self.cache.get_or_build(key, build)?;
        if let Origin::Rebuilt { damage, quarantined } = &entry.origin {
            self.progress.note(&format!(
                "warning: the cached {} was damaged ({damage}); it was moved to {} and made anew",
                key.stage(),
                quarantined.display()
            ));
        }
        Ok(entry)
    }

    /// The value of a key, which is made where the cache has none, and read back from the JSON file `name`.
    pub fn json<T: Serialize + DeserializeOwned>(
        &self,
        key: &Key,
        name: &str,
        make: impl FnOnce() -> Result<T, StageError>,
    ) -> Result<T, StageError> {
        let entry = self.entry(key, |work| {
            let path = work.join(name);
            let json = serde_json::to_vec(&make()?)?;
            Ok(std::fs::write(&path, json).map_err(|source| OutputError { path, source })?)
        })?;
        let path = entry.folder.join(name);
        let invalid = |reason: String| StageError::StoredAnswers { path: path.clone(), reason };
        let json = read_regular(&path, LARGEST_FILE).map_err(|error| invalid(error.to_string()))?;
        serde_json::from_slice(&json).map_err(|error| invalid(error.to_string()))
    }
}
