//! One writer at a time in a folder.

use super::StoreError;
use super::lock::{Lock, Waiting};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// The file that is locked, while a folder has a writer.
const NAME: &str = ".bench.lock";

/// The right to write into a folder, until it is dropped or the process ends, however it ends.
pub struct FolderLock {
    path: PathBuf,
    _lock: Lock,
}

impl FolderLock {
    /// Takes the lock of a folder that is there; calls `tell` whenever another process or thread has to be waited for.
    pub fn take(folder: &Path, tell: &dyn Fn(&Waiting)) -> Result<Self, StoreError> {
        let path = folder.join(NAME);
        loop {
            let lock = Lock::take(&path, &format!("what is in {}", folder.display()), tell)?;
            // Who held it before has removed the file, and another may hold a new one.
            if lock.is_at(&path)? {
                return Ok(Self { path, _lock: lock });
            }
        }
    }

    /// Whether a name in a folder is that of the lock.
    pub fn is_named(name: &OsStr) -> bool {
        name == NAME
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // What stays is taken by the next, as after a kill.
        let _ = fs::remove_file(&self.path);
    }
}
