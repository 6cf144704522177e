//! `manifest.json`: the birth certificate of a folder, and the mark that it was finished.

use super::FORMAT;
use super::error::{Fault, StoreError};
use super::file_record::FileRecord;
use super::hashed_file::{inside, read_small, read_verified, remove_if_there, verify_files, write_whole};
use super::table::{Row, Table};
use crate::{Seed, Split};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

const NAME: &str = "manifest.json";
const LIMIT: u64 = 64 << 20;

/// Where the data came from (scene, commit, adapter, options ...): free-form, kept as given.
pub type Provenance = BTreeMap<String, Value>;

/// What a folder holds, and the proof that it holds it still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`FORMAT`] of the version that wrote it.
    pub format: u32,
    /// What is in the folder.
    pub content: Content,
    /// How many of each: steps, detections, objects, instances, views.
    pub counts: BTreeMap<String, u64>,
    /// Every other file, by its path in the folder with `/`.
    pub files: BTreeMap<String, FileRecord>,
    /// Where it came from.
    pub provenance: Provenance,
    /// BLAKE3 of the rest of this manifest, and so of all that the folder holds: the dataset's hash.
    pub seal: String,
}

/// What a folder holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Content {
    /// An [`Episode`](crate::Episode).
    Episode {
        /// The seed that made it.
        seed: Seed,
    },
    /// A [`ViewSet`](crate::ViewSet).
    Views {
        /// The split all its instances belong to.
        split: Split,
    },
}

impl Manifest {
    pub(super) fn new<const N: usize>(
        content: Content,
        counts: [(&str, usize); N],
        files: BTreeMap<String, FileRecord>,
        provenance: Provenance,
    ) -> Self {
        let counts = counts.map(|(name, count)| (name.to_owned(), count as u64)).into();
        let unsealed = Self { format: FORMAT, content, counts, files, provenance, seal: String::new() };
        Self { seal: unsealed.computed_seal(), ..unsealed }
    }

    /// The hash of the rest as compact JSON with sorted keys.
    pub(super) fn computed_seal(&self) -> String {
        let mut value = json!({
            "format": self.format,
            "content": self.content,
            "counts": self.counts,
            "files": self.files,
            "provenance": self.provenance,
        });
        value.sort_all_objects();
        blake3::hash(value.to_string().as_bytes()).to_hex().to_string()
    }

    /// Size and hash of a file that the format asks for.
    pub(super) fn file(&self, folder: &Path, name: &str) -> Result<&FileRecord, StoreError> {
        let fault = || Fault::new(NAME, None, "files", "no such entry", format!("{name:?}"));
        self.files.get(name).ok_or_else(|| StoreError::invalid(folder)(fault()))
    }

    /// Reads a table whose bytes this manifest vouches for.
    pub(super) fn read_table<T>(
        &self,
        folder: &Path,
        table: &Table,
        take: impl Fn(&mut Row<'_>) -> Result<T, Fault>,
    ) -> Result<Vec<T>, StoreError> {
        let record = self.file(folder, table.file)?;
        read_verified(folder, table.file, record, |source| table.read(folder, source, take))
    }

    /// Likewise for a table that a folder need not have: `None` where it is not listed.
    pub(super) fn read_table_if_listed<T>(
        &self,
        folder: &Path,
        table: &Table,
        take: impl Fn(&mut Row<'_>) -> Result<T, Fault>,
    ) -> Result<Option<Vec<T>>, StoreError> {
        if !self.files.contains_key(table.file) {
            return Ok(None);
        }
        self.read_table(folder, table, take).map(Some)
    }

    /// Refuses a count that the data do not bear out.
    pub(super) fn check_count(&self, folder: &Path, name: &str, found: usize) -> Result<(), StoreError> {
        let got = self.counts.get(name).copied();
        if got == Some(found as u64) {
            return Ok(());
        }
        let got = got.map_or("nothing".to_owned(), |got| got.to_string());
        let fault =
            Fault::new(NAME, None, format!("counts.{name}"), got, format!("{found}, as in the files"));
        Err(StoreError::invalid(folder)(fault))
    }

    /// The refusal of a folder that holds something else.
    pub(super) fn not_the_kind(&self, folder: &Path, expected: &'static str) -> StoreError {
        let got = match self.content {
            Content::Episode { .. } => "an episode",
            Content::Views { .. } => "a view set",
        };
        StoreError::OtherKind { folder: folder.to_owned(), got, expected }
    }

    /// Commits the folder.
    pub(super) fn commit(self, folder: &Path) -> Result<Self, StoreError> {
        write_json(&folder.join(NAME), &self)?;
        Ok(self)
    }
}

/// Takes the mark of a finished folder away, before its files are written anew.
pub(super) fn withdraw(folder: &Path) -> Result<(), StoreError> {
    remove_if_there(&folder.join(NAME))
}

/// The manifest of a folder, of which only the manifest is checked; see [`verify`] for its files.
pub fn read_manifest(folder: &Path) -> Result<Manifest, StoreError> {
    let missing = |source: StoreError| match source {
        StoreError::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            StoreError::Unfinished { folder: folder.to_owned() }
        }
        other => other,
    };
    let manifest: Manifest = read_json(folder, NAME, FORMAT).map_err(missing)?;
    let seal = manifest.computed_seal();
    if manifest.seal != seal {
        let (got, expected) = (format!("blake3 {seal}"), format!("its seal, {}", manifest.seal));
        return Err(StoreError::Damaged { path: folder.join(NAME), got, expected });
    }
    manifest.files.keys().try_for_each(|name| inside(name)).map_err(StoreError::invalid(folder))?;
    Ok(manifest)
}

/// The manifest of a folder whose every file has the recorded size and hash: proof that it is finished and sound.
pub fn verify(folder: &Path) -> Result<Manifest, StoreError> {
    let manifest = read_manifest(folder)?;
    verify_files(folder, &manifest.files)?;
    Ok(manifest)
}

/// Writes a manifest as indented JSON, whole or not at all.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), StoreError> {
    let mut text = serde_json::to_vec_pretty(value).map_err(|e| StoreError::write(path)(e.into()))?;
    text.push(b'\n');
    write_whole(path, &text)
}

/// Reads a manifest of a format up to `newest`, and tells one of a newer format from one that is broken.
pub fn read_json<T: DeserializeOwned>(folder: &Path, name: &str, newest: u32) -> Result<T, StoreError> {
    let path = folder.join(name);
    let text = read_small(&path, LIMIT)?;
    let broken = |e: serde_json::Error| {
        let (line, column) = (Some(e.line() as u64), format!("column {}", e.column()));
        let fault = Fault::new(name, line, column, e, format!("format {newest}"));
        StoreError::invalid(folder)(fault)
    };
    let value: Value = serde_json::from_slice(&text).map_err(broken)?;
    match value.get("format").and_then(Value::as_u64) {
        Some(found) if found > u64::from(newest) => Err(StoreError::Newer { path, found, supported: newest }),
        Some(1..) => serde_json::from_slice(&text).map_err(broken),
        found => {
            let got = found.map_or("nothing".to_owned(), |found| found.to_string());
            Err(StoreError::invalid(folder)(Fault::new(name, None, "format", got, newest.to_string())))
        }
    }
}
