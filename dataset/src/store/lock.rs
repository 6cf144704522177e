//! Advisory locks that say who holds them.

use super::StoreError;
use std::fmt;
use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Somebody else makes what is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// What is made: the stage of a cache, or the data of a folder.
    pub stage: String,
    /// The process that makes it, as far as it is known.
    pub holder: Option<u32>,
    /// The file that is locked.
    pub lock: PathBuf,
}

impl fmt::Display for Waiting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let holder = self.holder.map_or("another process".to_owned(), |pid| format!("process {pid}"));
        write!(f, "waiting for {holder}, which makes {} (lock: {})", self.stage, self.lock.display())
    }
}

/// Held until dropped; the system drops it when the process ends, however it ends.
pub(super) struct Lock {
    file: File,
}

impl Lock {
    /// Takes the lock, and calls `tell` once before it waits.
    pub fn take(path: &Path, stage: &str, tell: &dyn Fn(&Waiting)) -> Result<Self, StoreError> {
        let take = || {
            let mut file = open(path)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    tell(&Waiting {
                        stage: stage.to_owned(),
                        holder: holder(&mut file),
                        lock: path.to_owned(),
                    });
                    file.lock()?;
                }
                Err(TryLockError::Error(error)) => return Err(error),
            }
            sign(&mut file)?;
            Ok(Self { file })
        };
        take().map_err(StoreError::write(path))
    }

    /// Takes a lock that nobody holds, and nobody has taken for `idle`.
    pub fn try_take_idle(path: &Path, idle: Duration) -> Result<Option<Self>, StoreError> {
        let take = || {
            let file = open(path)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(error)) => return Err(error),
            }
            let rested = file.metadata()?.modified()?.elapsed().unwrap_or_default() >= idle;
            Ok(rested.then_some(Self { file }))
        };
        take().map_err(StoreError::write(path))
    }

    /// Whether the file that is locked is still the one at `path`.
    pub fn is_at(&self, path: &Path) -> Result<bool, StoreError> {
        let same = || match std::fs::metadata(path) {
            Ok(there) => Ok(is_same(&self.file.metadata()?, &there)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(error) => Err(error),
        };
        same().map_err(StoreError::write(path))
    }
}

#[cfg(unix)]
fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Where a file that is open cannot be replaced.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}

fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)
}

fn sign(file: &mut File) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    write!(file, "{}", std::process::id())
}

fn holder(file: &mut File) -> Option<u32> {
    let mut text = String::new();
    file.take(16).read_to_string(&mut text).ok()?;
    text.parse().ok()
}
