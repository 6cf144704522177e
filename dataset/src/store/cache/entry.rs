//! Finished entries: `entry.json`, and the proof that an entry is what was made.

use super::super::FORMAT;
use super::super::error::{Fault, StoreError};
use super::super::file_record::FileRecord;
use super::super::hashed_file::{hash_and_sync, inside, make_folder, sync_folder, verify_files};
use super::super::manifest::{read_json, write_json};
use super::super::whole_file::file_kind;
use super::Key;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The commit mark of an entry.
pub(super) const NAME: &str = "entry.json";

/// `entry.json`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    format: u32,
    stage: String,
    key: String,
    /// What the key is the hash of, for the reader.
    inputs: Value,
    /// Every other file, by its path in the entry with `/`.
    files: BTreeMap<String, FileRecord>,
}

/// What stands at the place of an entry.
pub(super) enum State {
    /// Nothing.
    Absent,
    /// The entry, every hash of which is right.
    Sound,
    /// Something else, and why.
    Damaged(String),
}

/// Finds out what stands at the place of `key`. Data of a newer format are an error: they are not ours to replace.
pub(super) fn inspect(folder: &Path, key: &Key) -> Result<State, StoreError> {
    if !folder.exists() {
        return Ok(State::Absent);
    }
    let sound = read_json::<Record>(folder, NAME, FORMAT).and_then(|record| {
        if record.key != key.hash() || record.stage != key.stage() {
            let fault = Fault::new(NAME, None, "key", record.key, key.hash());
            return Err(StoreError::invalid(folder)(fault));
        }
        verify_files(folder, &record.files)
    });
    match sound {
        Ok(()) => Ok(State::Sound),
        Err(damage @ (StoreError::Damaged { .. } | StoreError::Invalid { .. })) => {
            Ok(State::Damaged(damage.finding()))
        }
        Err(StoreError::Read { path, source }) if source.kind() == ErrorKind::NotFound => {
            Ok(State::Damaged(format!("{} is missing", path.display())))
        }
        Err(other) => Err(other),
    }
}

/// Makes what is in `work` the entry of `key`, by one rename after everything is on disk.
pub(super) fn commit(work: &Path, folder: &Path, key: &Key) -> Result<(), StoreError> {
    let mut files = BTreeMap::new();
    collect(work, "", &mut files)?;
    let record = Record {
        format: FORMAT,
        stage: key.stage().to_owned(),
        key: key.hash().to_owned(),
        inputs: key.inputs().clone(),
        files,
    };
    write_json(&work.join(NAME), &record)?;
    let stage = folder.parent().unwrap_or(folder);
    make_folder(stage)?;
    fs::rename(work, folder).map_err(StoreError::write(folder))?;
    sync_folder(stage)
}

/// Hashes and syncs every file below `folder`, whose path in the entry is `prefix`.
fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, FileRecord>) -> Result<(), StoreError> {
    for path in list(folder)? {
        let name = format!("{prefix}{}", path.file_name().unwrap_or_default().to_string_lossy());
        inside(&name).map_err(StoreError::unfit(folder))?;
        let kind = fs::symlink_metadata(&path).map_err(StoreError::read(&path))?.file_type();
        if kind.is_dir() {
            collect(&path, &format!("{name}/"), files)?;
        } else if kind.is_file() {
            files.insert(name, hash_and_sync(&path)?);
        } else {
            let fault = Fault::new(&name, None, "type", file_kind(kind), "a regular file or a folder");
            return Err(StoreError::unfit(folder)(fault));
        }
    }
    sync_folder(folder)
}

/// What is in a folder, ordered by name.
pub(super) fn list(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let list = fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| entry.map(|e| e.path())).collect::<Result<Vec<_>, _>>());
    let mut paths = list.map_err(StoreError::read(folder))?;
    paths.sort();
    Ok(paths)
}
