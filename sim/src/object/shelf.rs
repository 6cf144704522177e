//! The folder of prepared meshes: `<mesh file and units>/<contents>.mesh`, both hashes.
//!
//! Which files a mesh names only its contents say, so the mesh file alone leads to those that were prepared of it. Of
//! these the one counts whose contents are those of all the files it names, which are read each time: nothing that was
//! changed goes unnoticed. There is one writer at a time for each mesh file, and what is damaged is made anew.

use super::prepared::{Facts, Prepared};
use crate::mesh_file::files::Files;
use crate::mesh_file::find::Source;
use crate::mesh_file::{MeshFault, MeshFileError, Units};
use crate::scene::UpAxis;
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{FolderLock, StoreError, make_folder};

/// What prepared meshes are called.
const ENDING: &str = "mesh";

/// A prepared file with its facts.
type Found = (PathBuf, Facts);

/// A mesh that was looked at: where it comes from, and its prepared file, where there is a folder for such.
#[derive(Clone, Debug)]
pub(super) struct Shelved {
    source: Source,
    units: Units,
    file: Option<PathBuf>,
}

impl Shelved {
    /// What is known of a mesh, which is prepared unless the folder `shelf` has it.
    pub fn look_at(
        source: &Source,
        units: Units,
        shelf: Option<&Path>,
    ) -> Result<(Self, Facts), MeshFileError> {
        let shelved = |file| Self { source: source.clone(), units, file };
        let Some(shelf) = shelf else { return Ok((shelved(None), Prepared::of(source, units)?.facts)) };
        let (folder, found) = find(shelf, source, units)?;
        if let Some((file, facts)) = found {
            return Ok((shelved(Some(file)), facts));
        }
        let _lock = lock(&folder).map_err(|error| source.error(MeshFault::NotKept(Box::new(error))))?;
        // Who had the lock may have made it.
        if let (_, Some((file, facts))) = find(shelf, source, units)? {
            return Ok((shelved(Some(file)), facts));
        }
        let prepared = Prepared::of(source, units)?;
        let file = folder.join(&prepared.facts.hash).with_extension(ENDING);
        keep(&prepared, &file).map_err(|error| source.error(MeshFault::NotKept(Box::new(error))))?;
        Ok((shelved(Some(file)), prepared.facts))
    }

    /// Where it comes from.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The mesh itself, whose contents have this hash; made anew where the prepared file is gone or damaged.
    pub fn fetch(&self, hash: &str) -> Result<Prepared, MeshFileError> {
        let stored = self.file.as_deref().and_then(Prepared::read);
        if let Some(stored) = stored.filter(|stored| stored.facts.hash == hash) {
            return Ok(stored);
        }
        let made = Prepared::of(&self.source, self.units)?;
        if made.facts.hash != hash {
            return Err(self.source.error(MeshFault::Changed));
        }
        if let Some(file) = &self.file {
            let folder = file.parent().unwrap_or(Path::new(""));
            let kept = lock(folder).and_then(|_lock| keep(&made, file));
            kept.map_err(|error| self.source.error(MeshFault::NotKept(Box::new(error))))?;
        }
        Ok(made)
    }
}

/// The folder of a mesh file, and what was prepared in it of the files as they are.
fn find(shelf: &Path, source: &Source, units: Units) -> Result<(PathBuf, Option<Found>), MeshFileError> {
    let mut files = Files::new(source)?;
    files.main()?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(files.hash().as_bytes());
    hasher.update(&units.metres_per_unit.to_le_bytes());
    hasher.update(match units.up {
        UpAxis::Z => b"z",
        UpAxis::Y => b"y",
    });
    let folder = shelf.join(hasher.finalize().to_hex().as_str());
    let entries = fs::read_dir(&folder).into_iter().flatten();
    let mut candidates: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    candidates.retain(|path| path.extension().is_some_and(|ending| ending == ENDING));
    candidates.sort();
    let found = candidates.into_iter().find_map(|file| {
        let facts = Facts::read(&file)?;
        // Where a file is missing, something else was prepared.
        let hash = files.hash_with(&facts.names).ok()?;
        (hash.to_hex().as_str() == facts.hash).then_some((file, facts))
    });
    Ok((folder, found))
}

fn lock(folder: &Path) -> Result<FolderLock, StoreError> {
    make_folder(folder)?;
    FolderLock::take(folder, &|_| ())
}

fn keep(prepared: &Prepared, file: &Path) -> Result<(), StoreError> {
    prepared.write(file).map_err(StoreError::write(file))
}
