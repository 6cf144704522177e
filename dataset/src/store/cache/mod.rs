//! A content-addressed cache: what a stage made from equal inputs is made once.
//!
//! ```text
//! cache.json                    the format of this folder
//! entries/<stage>/<key>/        finished: the stage's files and, written last, entry.json
//! work/<stage>-<key>/           being made, or left by a run that was killed
//! locks/<stage>-<key>           held while an entry is made; says by which process
//! quarantine/<stage>-<key>-<n>/ entries whose files were not those that were written
//! ```
//!
//! An entry appears by one rename, so that a reader sees all of it or nothing, and a killed run leaves only
//! work folders. The next run of the same stage on the same inputs is handed the same folder, with what is
//! in it, and may go on from there.

mod entry;
mod key;

use super::FORMAT;
use super::error::StoreError;
use super::hashed_file::{make_folder, remove_if_there, sync_folder};
use super::lock::{Lock, Waiting};
use super::manifest::{read_json, write_json};
pub use key::Key;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

const MARK: &str = "cache.json";

/// A folder of finished stages, shared by any number of processes and threads.
pub struct Cache {
    root: PathBuf,
    on_wait: Box<dyn Fn(&Waiting) + Send + Sync>,
}

/// A finished stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Holds the stage's files. Not to be written to.
    pub folder: PathBuf,
    /// How it came about.
    pub origin: Origin,
}

/// How an [`Entry`] came about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// It was there, and every file's hash was right.
    Stored,
    /// It was made now.
    Built,
    /// It was there but damaged, and was made anew: to be told to the user.
    Rebuilt {
        /// What was wrong with it.
        damage: String,
        /// Where the damaged entry is kept.
        quarantined: PathBuf,
    },
}

/// `cache.json`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mark {
    format: u32,
}

impl Cache {
    /// Opens the cache at `root`, which is made if need be. One of a newer format is refused and left alone.
    pub fn open(root: &Path) -> Result<Self, StoreError> {
        let cache = Self { root: root.to_owned(), on_wait: Box::new(|_| ()) };
        let mark = root.join(MARK);
        if !mark.exists() {
            for folder in ["entries", "work", "locks", "quarantine"] {
                make_folder(&root.join(folder))?;
            }
            let _lock = Lock::take(&root.join("locks").join("cache"), "cache", &cache.on_wait)?;
            if !mark.exists() {
                write_json(&mark, &Mark { format: FORMAT })?;
            }
        }
        read_json::<Mark>(root, MARK, FORMAT)?;
        Ok(cache)
    }

    /// Calls `tell` whenever another process or thread has to be waited for.
    pub fn on_wait(self, tell: impl Fn(&Waiting) + Send + Sync + 'static) -> Self {
        Self { on_wait: Box::new(tell), ..self }
    }

    /// The entry of `key`, made by `build` unless it is there and sound.
    ///
    /// `build` fills the folder that it is given. After a kill or an error that folder still holds what the
    /// last attempt left; `build` may go on from it, must not trust a file that it cannot check, and removes
    /// what is not part of the result. Only regular files and folders may be in it. Where two ask for one key at
    /// once, one builds, and the other waits and then reads.
    pub fn get_or_build<E: From<StoreError>>(
        &self,
        key: &Key,
        build: impl FnOnce(&Path) -> Result<(), E>,
    ) -> Result<Entry, E> {
        let folder = self.root.join("entries").join(key.stage()).join(key.hash());
        let stored = |folder| Ok(Entry { folder, origin: Origin::Stored });
        if matches!(entry::inspect(&folder, key)?, entry::State::Sound) {
            return stored(folder);
        }
        let name = key.to_string();
        let _lock = Lock::take(&self.root.join("locks").join(&name), key.stage(), &self.on_wait)?;
        let origin = match entry::inspect(&folder, key)? {
            entry::State::Sound => return stored(folder),
            entry::State::Absent => Origin::Built,
            entry::State::Damaged(damage) => {
                Origin::Rebuilt { damage, quarantined: self.quarantine(&folder, &name)? }
            }
        };
        let work = self.root.join("work").join(&name);
        make_folder(&work)?;
        remove_if_there(&work.join(entry::NAME))?;
        build(&work)?;
        entry::commit(&work, &folder, key)?;
        Ok(Entry { folder, origin })
    }

    /// Removes work folders that no run has taken up for `idle`, and returns them. Those in use are left alone.
    pub fn remove_abandoned_work(&self, idle: Duration) -> Result<Vec<PathBuf>, StoreError> {
        let mut removed = Vec::new();
        for work in entry::list(&self.root.join("work"))? {
            let Some(name) = work.file_name() else { continue };
            if let Some(lock) = Lock::try_take_idle(&self.root.join("locks").join(name), idle)? {
                fs::remove_dir_all(&work).map_err(StoreError::write(&work))?;
                drop(lock);
                removed.push(work);
            }
        }
        Ok(removed)
    }

    fn quarantine(&self, folder: &Path, name: &str) -> Result<PathBuf, StoreError> {
        let quarantine = self.root.join("quarantine");
        let free = (0u64..).map(|n| quarantine.join(format!("{name}-{n}"))).find(|path| !path.exists());
        let place = free.unwrap_or(quarantine);
        fs::rename(folder, &place).map_err(StoreError::write(&place))?;
        folder.parent().map_or(Ok(()), sync_folder)?;
        Ok(place)
    }
}
