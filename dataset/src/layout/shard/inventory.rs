//! The manifest of a dataset that is no row of shards: a folder or file for each object, scan or seed.

use super::manifest::{FINISHED, LayoutManifest, ObjectRecord, ShardRecord};
use super::record::record;
use crate::store::{Provenance, StoreError, hash_and_sync, remove_if_there, show_id};
use crate::{InstanceId, Split};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// What a dataset will hold once it is finished.
#[derive(Debug)]
pub struct Inventory {
    root: PathBuf,
    manifest: LayoutManifest,
    /// Name, split and number of samples of each folder or file.
    parts: Vec<(String, Split, u64)>,
}

impl Inventory {
    /// Of a folder, which may hold parts already; it counts as unfinished from now on.
    pub fn begin(root: &Path, layout: &str, provenance: Provenance) -> Result<Self, StoreError> {
        LayoutManifest::find(root)?;
        remove_if_there(&root.join(FINISHED))?;
        let manifest = LayoutManifest::new(layout, Value::Null, provenance);
        Ok(Self { root: root.to_owned(), manifest, parts: Vec::new() })
    }

    /// A folder or file below the root that is there, whole.
    pub fn add(&mut self, name: impl Into<String>, split: Split, samples: u64) {
        self.parts.push((name.into(), split, samples));
    }

    /// The licence of an object's mesh.
    pub fn add_licence(&mut self, instance: InstanceId, licence: &str) {
        let record = ObjectRecord { licence: Some(licence.to_owned()), ..ObjectRecord::default() };
        self.manifest.objects.insert(show_id(instance), record);
    }

    /// Hashes everything and writes `manifest.json`.
    pub fn finish(mut self) -> Result<(), StoreError> {
        for (name, split, samples) in self.parts {
            let content = record(&self.root.join(&name))?;
            let first = self.manifest.samples;
            self.manifest.shards.push(ShardRecord { name, split, first, samples, content });
            self.manifest.samples += samples;
        }
        for entry in fs::read_dir(&self.root).map_err(StoreError::read(&self.root))? {
            let entry = entry.map_err(StoreError::read(&self.root))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_part = self.manifest.shards.iter().any(|part| part.name == name);
            if !is_part && !name.starts_with('.') && entry.path().is_file() {
                self.manifest.files.insert(name, hash_and_sync(&entry.path())?);
            }
        }
        self.manifest.write_finished(&self.root)
    }
}
