//! Size and hash of a shard, be it a file or a folder.

use rayon::prelude::*;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use vantage_dataset::store::{Fault, FileRecord, StoreError, file_kind, hash_and_sync, sync_folder};

/// The record of a file, or of all files in a folder; what was written of them is on disk afterwards.
pub(super) fn record(path: &Path) -> Result<FileRecord, StoreError> {
    if !path.is_dir() {
        return hash_and_sync(path);
    }
    let mut names = Vec::new();
    list(path, "", &mut names)?;
    names.sort_unstable();
    let records: Vec<_> =
        names.par_iter().map(|name| hash_and_sync(&path.join(name))).collect::<Result<_, _>>()?;
    let mut listing = String::new();
    for (name, record) in names.iter().zip(&records) {
        let _ = writeln!(listing, "{name} {} {}", record.bytes, record.blake3);
    }
    let blake3 = blake3::hash(listing.as_bytes()).to_hex().to_string();
    Ok(FileRecord { bytes: records.iter().map(|record| record.bytes).sum(), blake3 })
}

/// Adds the paths below `prefix`, with `/`.
fn list(root: &Path, prefix: &str, names: &mut Vec<String>) -> Result<(), StoreError> {
    let folder = root.join(prefix);
    for entry in fs::read_dir(&folder).map_err(StoreError::read(&folder))? {
        let entry = entry.map_err(StoreError::read(&folder))?;
        let kind = entry.file_type().map_err(StoreError::read(&entry.path()))?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if kind.is_dir() {
            list(root, &format!("{name}/"), names)?;
        } else if kind.is_file() {
            names.push(name);
        } else {
            let fault = Fault::new(&name, None, "type", file_kind(kind), "a regular file, not a link");
            return Err(StoreError::invalid(root)(fault));
        }
    }
    sync_folder(&folder)
}
