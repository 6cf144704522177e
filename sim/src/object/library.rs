//! The meshes that a scene names.

use super::Object;
use super::prepared::Prepared;
use super::shelf::Shelved;
use crate::error::{Progress, Stage};
use crate::mesh_file::find::{self, Source};
use crate::mesh_file::{MeshFault, MeshFileError, Units};
use crate::scene::{MeshSpec, UpAxis};
use nalgebra::Vector3;
use serde::{Serialize, Serializer};
use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use vantage_dataset::{InstanceId, Split, Symmetry};

/// All meshes of a scene, each an object, in the order in which the scene names them.
///
/// It holds what there is to know of each; the object itself is read where it is asked for, and dropped after use.
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
    /// What detections of it are labelled with: the first 8 bytes of the hash.
    #[serde(skip)]
    pub id: InstanceId,
    /// Half its extents along x, y, z, metres.
    #[serde(skip)]
    pub half_extents: Vector3<f64>,
    /// Memory that the object takes, bytes.
    #[serde(skip)]
    pub bytes: u64,
    #[serde(skip)]
    shelved: Shelved,
}

impl MeshEntry {
    /// The object, read anew each time.
    ///
    /// # Errors
    /// [`MeshFault::Changed`] where the files are not those that the library was made of, and those of
    /// [`MeshLibrary::load`].
    pub fn object(&self) -> Result<Object, MeshFileError> {
        let Prepared { model, shape, .. } = self.shelved.fetch(&self.hash)?;
        Ok(Object::from_mesh(self.id, self.category.clone(), self.symmetry, shape, model))
    }

    /// The mesh file.
    pub fn file(&self) -> &Path {
        &self.shelved.source().file
    }

    /// A licence file that lies beside it.
    pub fn licence(&self) -> Option<&Path> {
        self.shelved.source().licence.as_deref()
    }

    /// Radius of the circle around its footprint where it stands upright, metres.
    pub fn footprint(&self) -> f64 {
        libm::hypot(self.half_extents.x, self.half_extents.y)
    }
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
    /// Looks at all meshes; paths are relative to the folder `base`.
    ///
    /// A mesh is prepared once, as many at a time as there are threads, and kept in the folder `shelf`, which is made if need
    /// be. It holds meshes as this code prepares them: other code needs another folder. Without one, nothing is kept, and
    /// each object is prepared whenever it is asked for.
    ///
    /// # Errors
    /// Of the first mesh that cannot be used, or whose prepared form cannot be written; and of one that is there twice.
    pub fn load(
        specs: &[MeshSpec],
        base: &Path,
        shelf: Option<&Path>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Self, MeshFileError> {
        let mut wanted = Vec::new();
        for spec in specs {
            wanted.extend(find::find(&base.join(&spec.path))?.into_iter().map(|source| (spec, source)));
        }
        let meshes = entries(&wanted, shelf, progress)?;
        let mut known: HashMap<&str, &MeshEntry> = HashMap::new();
        for (mesh, (_, source)) in meshes.iter().zip(&wanted) {
            if let Some(twin) = known.insert(&mesh.hash, mesh) {
                return Err(source.error(MeshFault::Twice(twin.file().to_owned())));
            }
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

/// The meshes in their order, or the error of the first that has one.
fn entries(
    wanted: &[(&MeshSpec, Source)],
    shelf: Option<&Path>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Vec<MeshEntry>, MeshFileError> {
    let total = wanted.len() as u64;
    let mut tell = |done| progress(Progress { stage: Stage::Meshes, done, total });
    if total > 0 {
        tell(0);
    }
    let next = AtomicUsize::new(0);
    let mut looked: Vec<(usize, Result<MeshEntry, MeshFileError>)> = Vec::with_capacity(wanted.len());
    // Threads of their own may wait, for memory or for another process, where those of a pool would take up other work.
    thread::scope(|scope| {
        let (done, all_done) = mpsc::channel();
        for _ in 0..rayon::current_num_threads().min(wanted.len()) {
            let (done, next) = (done.clone(), &next);
            scope.spawn(move || {
                while let Some((index, (spec, source))) = take_turn(next, wanted) {
                    let entry = entry(spec, source, shelf);
                    if entry.is_err() {
                        // Those before it have been taken up, so that the first error is the same in each run.
                        next.store(wanted.len(), Ordering::Relaxed);
                    }
                    if done.send((index, entry)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        for one in all_done {
            looked.push(one);
            tell(looked.len() as u64);
        }
    });
    looked.sort_by_key(|(index, _)| *index);
    looked.into_iter().map(|(_, entry)| entry).collect()
}

/// The next of them that nobody has taken, with its index.
fn take_turn<'a, T>(next: &AtomicUsize, all: &'a [T]) -> Option<(usize, &'a T)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    all.get(index).map(|one| (index, one))
}

fn entry(spec: &MeshSpec, source: &Source, shelf: Option<&Path>) -> Result<MeshEntry, MeshFileError> {
    let units = Units { metres_per_unit: spec.metres_per_unit, up: spec.up };
    let (shelved, facts) = Shelved::look_at(source, units, shelf)?;
    Ok(MeshEntry {
        name: source.name.clone(),
        category: spec.category.clone().unwrap_or_else(|| source.name.clone()),
        split: spec.split.unwrap_or_else(|| split_of(&source.name)),
        id: facts.id,
        half_extents: facts.half_extents.into(),
        bytes: facts.bytes(),
        hash: facts.hash,
        metres_per_unit: spec.metres_per_unit,
        up: spec.up,
        symmetry: spec.symmetry.into(),
        shelved,
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
