//! The meshes that a scene names.

use super::Object;
use crate::error::{Progress, Stage};
use crate::mesh_file::find::{self, Source};
use crate::mesh_file::{self, Loaded, MeshFault, MeshFileError, Units};
use crate::scene::{MeshSpec, UpAxis};
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vantage_dataset::{InstanceId, Split, Symmetry};

/// Most memory that the meshes of a scene may take, bytes.
const MAX_BYTES: usize = 1_500_000_000;
/// Meshes read at a time; of a hostile one the images may take half a gigabyte.
const BATCH: usize = 4;

/// All meshes of a scene, each an object, in the order in which the scene names them.
///
/// It is serialized as what decides how the objects look, file contents included: as part of a key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshLibrary {
    meshes: Arc<[MeshEntry]>,
}

/// One mesh.
#[derive(Clone, Debug, Serialize)]
pub struct MeshEntry {
    /// Name of the model.
    pub name: String,
    /// Category of the object.
    pub category: String,
    /// The split that the object belongs to.
    pub split: Split,
    /// BLAKE3 hash of the contents of all files that it was read from, hexadecimal.
    pub hash: String,
    /// Length of the file's unit, metres.
    pub metres_per_unit: f64,
    /// The file's axis that points up.
    pub up: UpAxis,
    /// Turns about z that leave its look unchanged.
    pub symmetry: Symmetry,
    /// The mesh file.
    #[serde(skip)]
    pub file: PathBuf,
    /// A licence file that lies beside it.
    #[serde(skip)]
    pub licence: Option<PathBuf>,
    /// The object.
    #[serde(skip)]
    pub object: Object,
}

impl PartialEq for MeshEntry {
    fn eq(&self, other: &Self) -> bool {
        let key = |entry: &Self| {
            let unit = entry.metres_per_unit.to_bits();
            (entry.category.clone(), entry.split, entry.hash.clone(), unit, entry.up, entry.symmetry)
        };
        self.name == other.name && key(self) == key(other)
    }
}

impl Serialize for MeshLibrary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl MeshLibrary {
    /// Reads all meshes; paths are relative to the folder `base`.
    pub fn load(
        specs: &[MeshSpec],
        base: &Path,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Self, MeshFileError> {
        let mut wanted = Vec::new();
        for spec in specs {
            wanted.extend(find::find(&base.join(&spec.path))?.into_iter().map(|source| (spec, source)));
        }
        let total = wanted.len() as u64;
        let mut tell = |done: usize| progress(Progress { stage: Stage::Meshes, done: done as u64, total });
        if total > 0 {
            tell(0);
        }
        let mut meshes: Vec<MeshEntry> = Vec::with_capacity(wanted.len());
        let mut taken = 0;
        for batch in wanted.chunks(BATCH) {
            let loaded: Vec<Result<MeshEntry, MeshFileError>> =
                batch.par_iter().map(|(spec, source)| entry(spec, source)).collect();
            for (mesh, (_, source)) in loaded.into_iter().zip(batch) {
                let mesh = mesh?;
                taken += bytes(&mesh.object);
                if taken > MAX_BYTES {
                    return Err(source.error(MeshFault::SceneTooLarge { bytes: taken, limit: MAX_BYTES }));
                }
                if let Some(twin) = meshes.iter().find(|other| other.hash == mesh.hash) {
                    return Err(source.error(MeshFault::Twice(twin.file.clone())));
                }
                meshes.push(mesh);
            }
            tell(meshes.len());
        }
        Ok(Self { meshes: meshes.into() })
    }

    /// True if the scene names no mesh.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty()
    }

    /// All meshes.
    pub fn iter(&self) -> impl Iterator<Item = &MeshEntry> {
        self.meshes.iter()
    }
}

fn entry(spec: &MeshSpec, source: &Source) -> Result<MeshEntry, MeshFileError> {
    let units = Units { metres_per_unit: spec.metres_per_unit, up: spec.up };
    let Loaded { model, hash } = mesh_file::load(source, units)?;
    let mut id = [0; 8];
    id.copy_from_slice(&hash.as_bytes()[..8]);
    let category = spec.category.clone().unwrap_or_else(|| source.name.clone());
    let id = InstanceId(u64::from_le_bytes(id));
    let symmetry = spec.symmetry.into();
    let object = Object::from_mesh(id, category.clone(), symmetry, model)
        .ok_or_else(|| source.error(MeshFault::NoVolume))?;
    Ok(MeshEntry {
        name: source.name.clone(),
        category,
        split: spec.split.unwrap_or_else(|| split_of(&source.name)),
        hash: hash.to_hex().to_string(),
        metres_per_unit: spec.metres_per_unit,
        up: spec.up,
        symmetry,
        file: source.file.clone(),
        licence: source.licence.clone(),
        object,
    })
}

/// Of five names three train, one validates and one tests, by the hash of the name.
fn split_of(name: &str) -> Split {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&blake3::hash(name.as_bytes()).as_bytes()[..8]);
    match u64::from_le_bytes(bytes) % 5 {
        0..3 => Split::Train,
        3 => Split::Validation,
        _ => Split::Test,
    }
}

fn bytes(object: &Object) -> usize {
    let mesh = &object.model.mesh;
    let texels = object.model.texture.texels().len();
    32 * mesh.positions.len() + 12 * mesh.triangles.len() + 4 * texels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_sixty_twenty_twenty() {
        let splits: Vec<Split> = (0..10_000).map(|i| split_of(&format!("model_{i}"))).collect();
        let share = |split| splits.iter().filter(|&&s| s == split).count() as f64 / 1e4;
        for (split, expected) in [(Split::Train, 0.6), (Split::Validation, 0.2), (Split::Test, 0.2)] {
            assert!((share(split) - expected).abs() < 0.02, "{split:?}: {}", share(split));
        }
    }
}
