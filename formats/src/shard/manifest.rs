//! `manifest.json` of a dataset in shards: what it holds, how it was made, and how far it is.

use super::record::record;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::Split;
use vantage_dataset::store::{
    Fault, FileRecord, Provenance, StoreError, inside, read_json, remove_if_there, verify_files, write_json,
};

/// The format this version writes, and the newest it reads. From 2 on crops carry their time and camera.
pub const FORMAT: u32 = 2;

const FINISHED: &str = "manifest.json";
const PARTIAL: &str = "manifest.partial.json";

/// What a dataset folder holds, and the proof that it holds it still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayoutManifest {
    /// [`FORMAT`] of the version that wrote it.
    pub format: u32,
    /// Name of the format: `webdataset`, `bop`, `tum` ...
    pub layout: String,
    /// The writer's options; none of those that have no shards.
    pub options: Value,
    /// Where the data came from.
    pub provenance: Provenance,
    /// Samples (crops, images or poses) in all shards.
    pub samples: u64,
    /// In the order of their samples: shards, or the folders and files of objects, scans or seeds.
    pub shards: Vec<ShardRecord>,
    /// By instance id, 16 hexadecimal digits: the objects of which a number, a mesh or a licence was told.
    pub objects: BTreeMap<String, ObjectRecord>,
    /// The files beside shards and meshes.
    pub files: BTreeMap<String, FileRecord>,
    /// BLAKE3 of the rest of this manifest as compact JSON with sorted keys: the dataset's hash.
    pub seal: String,
}

/// One finished shard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShardRecord {
    /// Its file, or its folder, by the path in the dataset with `/`.
    pub name: String,
    /// The split of all its samples.
    pub split: Split,
    /// How many samples come before it.
    pub first: u64,
    /// How many samples it holds.
    pub samples: u64,
    /// Size and hash of the file; of a folder the size of its files together, and the hash of their sorted list with a
    /// line `<path> <bytes> <blake3>` each.
    pub content: FileRecord,
}

/// What is known of an object besides its samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectRecord {
    /// Its number in a BOP dataset.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub obj_id: Option<u32>,
    /// The licence of its mesh; none for one that the program itself made.
    pub licence: Option<String>,
    /// Its entry of `models_info.json`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub model: Option<Value>,
    /// Files of its mesh.
    #[serde(skip_serializing_if = "BTreeMap::is_empty", default)]
    pub files: BTreeMap<String, FileRecord>,
}

impl LayoutManifest {
    pub(super) fn new(layout: &str, options: Value, provenance: Provenance) -> Self {
        Self {
            format: FORMAT,
            layout: layout.to_owned(),
            options,
            provenance,
            samples: 0,
            shards: Vec::new(),
            objects: BTreeMap::new(),
            files: BTreeMap::new(),
            seal: String::new(),
        }
    }

    /// The manifest of a dataset and whether it is finished; none where the folder holds no manifest.
    pub(super) fn find(folder: &Path) -> Result<Option<(Self, bool)>, StoreError> {
        for (name, finished) in [(FINISHED, true), (PARTIAL, false)] {
            if !folder.join(name).exists() {
                continue;
            }
            if read_json::<Value>(folder, name, FORMAT)?.get("layout").is_none() {
                return Err(StoreError::Foreign { folder: folder.to_owned() });
            }
            let manifest: Self = read_json(folder, name, FORMAT)?;
            let seal = manifest.computed_seal();
            if manifest.seal != seal {
                let (got, expected) = (format!("blake3 {seal}"), format!("its seal, {}", manifest.seal));
                return Err(StoreError::Damaged { path: folder.join(name), got, expected });
            }
            let shards = manifest.shards.iter().map(|shard| &shard.name);
            let meshes = manifest.objects.values().flat_map(|object| object.files.keys());
            let mut names = shards.chain(meshes).chain(manifest.files.keys());
            names.try_for_each(|name| inside(name)).map_err(StoreError::invalid(folder))?;
            return Ok(Some((manifest, finished)));
        }
        Ok(None)
    }

    /// Refuses to go on with what was begun otherwise.
    pub(super) fn require_same(&self, folder: &Path, asked: &Self) -> Result<(), StoreError> {
        let layout = (Value::from(self.layout.as_str()), Value::from(asked.layout.as_str()));
        let provenance = [&self.provenance, &asked.provenance]
            .map(|provenance| provenance.iter().map(|(key, value)| (key.clone(), value.clone())).collect());
        let [ours, theirs] = provenance;
        let parts = [
            ("layout", layout.0, layout.1),
            ("format", self.format.into(), asked.format.into()),
            ("options", self.options.clone(), asked.options.clone()),
            ("provenance", ours, theirs),
        ];
        for (field, found, asked) in parts {
            if let Some((field, asked, found)) = difference(field.to_owned(), &found, &asked) {
                let name = if folder.join(FINISHED).exists() { FINISHED } else { PARTIAL };
                let fault = Fault::new(name, None, field, asked, format!("{found}, with which it was begun"));
                return Err(StoreError::Differs { folder: folder.to_owned(), fault: Box::new(fault) });
            }
        }
        Ok(())
    }

    /// What is wrong with the first damaged shard, and its index.
    pub(super) fn damaged_shard(&self, folder: &Path) -> Result<Option<(usize, StoreError)>, StoreError> {
        for (i, shard) in self.shards.iter().enumerate() {
            if let Some(damage) = damage(shard.verify(folder))? {
                return Ok(Some((i, damage)));
            }
        }
        Ok(None)
    }

    /// What is wrong with the meshes.
    pub(super) fn damaged_mesh(&self, folder: &Path) -> Result<Option<StoreError>, StoreError> {
        damage(self.objects.values().try_for_each(|object| verify_files(folder, &object.files)))
    }

    /// What is wrong with the files beside shards and meshes.
    pub(super) fn damaged_file(&self, folder: &Path) -> Result<Option<StoreError>, StoreError> {
        damage(verify_files(folder, &self.files))
    }

    pub(super) fn write_partial(&mut self, folder: &Path) -> Result<(), StoreError> {
        self.seal = self.computed_seal();
        write_json(&folder.join(PARTIAL), self)
    }

    /// Commits the dataset.
    pub(super) fn write_finished(&mut self, folder: &Path) -> Result<(), StoreError> {
        self.seal = self.computed_seal();
        write_json(&folder.join(FINISHED), self)?;
        self.clear_partial(folder)
    }

    /// Removes what a run leaves that was killed just after it had committed the dataset.
    pub(super) fn clear_partial(&self, folder: &Path) -> Result<(), StoreError> {
        remove_if_there(&folder.join(PARTIAL))
    }

    /// Takes the mark of a finished dataset away.
    pub(super) fn withdraw(&mut self, folder: &Path) -> Result<(), StoreError> {
        self.write_partial(folder)?;
        remove_if_there(&folder.join(FINISHED))
    }

    fn computed_seal(&self) -> String {
        let unsealed = Self { seal: String::new(), ..self.clone() };
        let mut value = serde_json::json!(unsealed);
        value.sort_all_objects();
        blake3::hash(value.to_string().as_bytes()).to_hex().to_string()
    }
}

impl ShardRecord {
    fn verify(&self, folder: &Path) -> Result<(), StoreError> {
        let path = folder.join(&self.name);
        if !path.is_dir() {
            return verify_files(folder, [(&self.name, &self.content)]);
        }
        let found = record(&path)?;
        if found == self.content {
            return Ok(());
        }
        let show = |record: &FileRecord| format!("{} bytes, blake3 {}", record.bytes, record.blake3);
        Err(StoreError::Damaged { path, got: show(&found), expected: show(&self.content) })
    }
}

/// The manifest of a dataset whose every file has the recorded size and hash: proof that it is finished and sound.
pub fn verify_layout(folder: &Path) -> Result<LayoutManifest, StoreError> {
    match LayoutManifest::find(folder)? {
        Some((manifest, true)) => {
            manifest.shards.iter().try_for_each(|shard| shard.verify(folder))?;
            manifest.objects.values().try_for_each(|object| verify_files(folder, &object.files))?;
            verify_files(folder, &manifest.files)?;
            Ok(manifest)
        }
        _ => Err(StoreError::Unfinished { folder: folder.to_owned() }),
    }
}

/// Tells damage, which can be mended by writing again, from other failures.
fn damage(result: Result<(), StoreError>) -> Result<Option<StoreError>, StoreError> {
    match result {
        Ok(()) => Ok(None),
        Err(damage @ (StoreError::Damaged { .. } | StoreError::Invalid { .. })) => Ok(Some(damage)),
        Err(other) => Err(other),
    }
}

/// The innermost field in which two values differ, with what `asked` and `found` hold there.
fn difference(field: String, found: &Value, asked: &Value) -> Option<(String, Value, Value)> {
    if found == asked {
        return None;
    }
    if let (Value::Object(found), Value::Object(asked)) = (found, asked) {
        let keys: std::collections::BTreeSet<_> = found.keys().chain(asked.keys()).collect();
        return keys.into_iter().find_map(|key| {
            let part =
                |object: &serde_json::Map<String, Value>| object.get(key).cloned().unwrap_or(Value::Null);
            difference(format!("{field}.{key}"), &part(found), &part(asked))
        });
    }
    Some((field, asked.clone(), found.clone()))
}
