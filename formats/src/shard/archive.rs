//! A shard that is a tar archive whose bytes depend on its members alone.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::Path;
use tar::{Archive, Builder, EntryType, Header};
use vantage_dataset::store::{StoreError, open_regular};

/// A tar archive under way.
pub(crate) struct TarShard(Builder<BufWriter<File>>);

impl TarShard {
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        Ok(Self(Builder::new(BufWriter::new(File::create(path)?))))
    }

    /// Adds a member: no time, no owner, mode 0644.
    pub(crate) fn add(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let mut header = Header::new_ustar();
        header.set_entry_type(EntryType::Regular);
        header.set_mode(0o644);
        header.set_uid(0);
        header.set_gid(0);
        header.set_mtime(0);
        header.set_size(bytes.len() as u64);
        self.0.append_data(&mut header, name, bytes)
    }

    pub(crate) fn close(self) -> io::Result<()> {
        self.0.into_inner()?.flush()
    }
}

impl std::fmt::Debug for TarShard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("TarShard")
    }
}

/// The sample keys of an archive, in order: what its members' names have before the first dot.
pub(crate) fn keys_of_tar(path: &Path) -> Result<Vec<String>, StoreError> {
    let read = || {
        let mut archive = Archive::new(BufReader::new(open_regular(path)?));
        let mut keys: Vec<String> = Vec::new();
        for entry in archive.entries_with_seek()? {
            let entry = entry?;
            let name = entry.path()?.to_string_lossy().into_owned();
            let key = name.split('.').next().unwrap_or_default();
            if keys.last().is_none_or(|last| last != key) {
                keys.push(key.to_owned());
            }
        }
        Ok(keys)
    };
    read().map_err(StoreError::read(path))
}
