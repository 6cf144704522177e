//! The manifest of a dataset that is no row of shards: a folder or file for each object, scan or seed.

use super::holds_foreign;
use super::manifest::{LayoutManifest, ObjectRecord, ShardRecord};
use super::record::record;
use serde_json::Value;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{FileRecord, Provenance, StoreError, hash_and_sync, make_folder};
use vantage_dataset::{InstanceId, Split};

/// What a dataset will hold once it is finished.
#[derive(Debug)]
pub struct Inventory {
    root: PathBuf,
    /// What an earlier run left.
    before: Option<LayoutManifest>,
    withdrawn: bool,
    manifest: LayoutManifest,
    parts: Vec<Part>,
}

#[derive(Debug)]
struct Part {
    name: String,
    split: Split,
    samples: u64,
    /// Whether an earlier run wrote it.
    kept: bool,
}

impl Inventory {
    /// Of a folder, which may hold parts already.
    pub fn begin(root: &Path, layout: &str, provenance: Provenance) -> Result<Self, StoreError> {
        let before = LayoutManifest::find(root)?.map(|(manifest, _)| manifest);
        let manifest = LayoutManifest::new(layout, Value::Null, provenance);
        Ok(Self { root: root.to_owned(), before, withdrawn: false, manifest, parts: Vec::new() })
    }

    /// Of what an earlier run wrote here, if there was one.
    pub fn before(&self) -> Option<&Provenance> {
        self.before.as_ref().map(|before| &before.provenance)
    }

    /// Makes a folder without a manifest this dataset's, or refuses it if it holds anything.
    pub fn claim(&mut self) -> Result<(), StoreError> {
        if self.before.is_some() {
            return Ok(());
        }
        if holds_foreign(&self.root)? {
            return Err(StoreError::Foreign { folder: self.root.clone() });
        }
        make_folder(&self.root)?;
        self.manifest.write_partial(&self.root)
    }

    /// Before something is written: the dataset counts as unfinished from now on.
    pub fn withdraw(&mut self) -> Result<(), StoreError> {
        match &mut self.before {
            Some(before) if !self.withdrawn => before.withdraw(&self.root)?,
            _ => {}
        }
        self.withdrawn = true;
        Ok(())
    }

    /// A folder or file below the root that was written whole.
    pub fn add(&mut self, name: impl Into<String>, split: Split, samples: u64) {
        self.push(Part { name: name.into(), split, samples, kept: false });
    }

    /// One that an earlier run wrote.
    pub fn keep(&mut self, name: impl Into<String>, split: Split, samples: u64) {
        self.push(Part { name: name.into(), split, samples, kept: true });
    }

    /// Two seeds may show one object.
    fn push(&mut self, part: Part) {
        if self.parts.iter().all(|other| other.name != part.name) {
            self.parts.push(part);
        }
    }

    /// The licence of an object's mesh.
    pub fn add_licence(&mut self, instance: InstanceId, licence: &str) {
        let record = ObjectRecord { licence: Some(licence.to_owned()), ..ObjectRecord::default() };
        self.manifest.objects.insert(instance.to_string(), record);
    }

    /// Hashes the parts, and `files` where they are there, and writes `manifest.json`. A kept part has to be as an earlier manifest
    /// has it.
    pub fn finish(mut self, files: &[&str]) -> Result<(), StoreError> {
        for Part { name, split, samples, kept } in self.parts {
            let path = self.root.join(&name);
            let content = record(&path)?;
            let parts = self.before.iter().flat_map(|before| &before.shards);
            let expected = parts.filter(|part| kept && part.name == name).map(|part| &part.content).next();
            if let Some(expected) = expected.filter(|expected| **expected != content) {
                let show = |record: &FileRecord| format!("{} bytes, blake3 {}", record.bytes, record.blake3);
                return Err(StoreError::Damaged { path, got: show(&content), expected: show(expected) });
            }
            let first = self.manifest.samples;
            self.manifest.shards.push(ShardRecord { name, split, first, samples, content });
            self.manifest.samples += samples;
        }
        for name in files {
            let path = self.root.join(name);
            if path.exists() {
                self.manifest.files.insert((*name).to_owned(), hash_and_sync(&path)?);
            }
        }
        self.manifest.write_finished(&self.root)
    }
}
