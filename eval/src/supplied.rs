//! What comes with the program and is in it: scenes, studies, maps and reference models, so that it works without the repository.

use crate::progress::Progress;
use crate::scene_file::{self, FileKind, SceneFile};
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Cache, Key, Origin, StoreError};
use vantage_sim::scene::WorldSpec;

include!(concat!(env!("OUT_DIR"), "/supplied.rs"));

/// Name of the stage under which the cache keeps the files.
const STAGE: &str = "supplied";

/// A scene, a study or a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supplied {
    /// Its path from the workspace's root.
    pub path: &'static str,
    /// Its YAML.
    pub text: &'static str,
    /// What it is.
    pub kind: FileKind,
}

impl Supplied {
    /// The name by which commands take it: that of the file, without `.yaml`.
    pub fn name(&self) -> &'static str {
        self.path.rsplit('/').next().unwrap_or(self.path).trim_end_matches(".yaml")
    }
}

/// Every scene, study and map, by path. Scenes that only studies use are among them.
pub fn files() -> impl Iterator<Item = Supplied> {
    FILES.iter().filter_map(|(path, bytes)| {
        let text = std::str::from_utf8(bytes).ok().filter(|_| path.ends_with(".yaml"))?;
        Some(Supplied { path, text, kind: FileKind::of(text)? })
    })
}

/// The files of a kind that lie in the folder of their kind.
pub fn of_kind(kind: FileKind) -> impl Iterator<Item = Supplied> {
    let lies_there = move |file: &Supplied| Path::new(file.path).starts_with(kind.folder());
    files().filter(move |file| file.kind == kind && lies_there(file))
}

/// The scenes that serve studies and maps alone, and lie elsewhere: those that read no file but their own, of names that no scene has.
pub fn scenes_for_studies() -> impl Iterator<Item = Supplied> {
    let has_all = |file: &Supplied| {
        let scene: Option<SceneFile> = scene_file::parse(file.text, Path::new(file.path)).ok();
        scene.is_some_and(|scene| {
            let WorldSpec { meshes, fixtures, .. } = &scene.world;
            meshes.is_empty() && fixtures.is_empty() && scene.evaluation.episodes.is_none()
        })
    };
    files()
        .filter(|file| file.kind == FileKind::Scene && file.path.starts_with("studies/"))
        .filter(|file| of_kind(FileKind::Scene).all(|scene| scene.name() != file.name()))
        .filter(has_all)
}

/// Name and kind of each reference model.
pub fn models() -> impl Iterator<Item = (&'static str, &'static str)> {
    FILES.iter().filter_map(|(path, bytes)| {
        let name = path.strip_prefix("models/")?.strip_suffix("/model.yaml")?;
        let manifest = std::str::from_utf8(bytes).ok()?;
        Some((name, manifest.lines().find_map(|line| line.strip_prefix("kind: "))?))
    })
}

/// The folder of the reference model of a name, laid out in the cache; `None` where there is no such model.
pub fn model(name: &str, cache: &Path) -> Result<Option<PathBuf>, StoreError> {
    match models().any(|(other, _)| other == name) {
        true => Ok(Some(lay_out(cache)?.join("models").join(name))),
        false => Ok(None),
    }
}

/// The folder of the cache that holds all of it as the repository does, made where it is not there; every file's hash is checked.
pub fn lay_out(cache: &Path) -> Result<PathBuf, StoreError> {
    let hashes: Vec<_> =
        FILES.iter().map(|(path, bytes)| (path, blake3::hash(bytes).to_hex().to_string())).collect();
    let entry = Cache::open(cache)?.get_or_build(&Key::new(STAGE, &hashes)?, |work| {
        FILES.iter().try_for_each(|(path, bytes)| {
            let place = work.join(path);
            let made = place.parent().map_or(Ok(()), fs::create_dir_all);
            made.and_then(|()| fs::write(&place, bytes))
                .map_err(|source| StoreError::Write { path: place, source })
        })
    })?;
    if let Origin::Rebuilt { damage, .. } = &entry.origin {
        let folder = entry.folder.display();
        Progress::detect().note(&format!("warning: {folder} was damaged ({damage}), and was made anew"));
    }
    Ok(entry.folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_learn::Model;

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
    }

    #[test]
    fn what_is_laid_out_is_what_the_repository_holds_and_damage_is_mended() {
        let cache = tempfile::tempdir().unwrap();
        let folder = lay_out(cache.path()).unwrap();
        for (path, _) in FILES {
            assert_eq!(fs::read(folder.join(path)).unwrap(), fs::read(root().join(path)).unwrap(), "{path}");
        }
        let damaged = folder.join("scenes/tabletop.yaml");
        fs::write(&damaged, "name: other\n").unwrap();
        assert_eq!(lay_out(cache.path()).unwrap(), folder);
        assert_eq!(fs::read(damaged).unwrap(), fs::read(root().join("scenes/tabletop.yaml")).unwrap());
    }

    #[test]
    fn every_file_is_there_and_scenes_find_their_models() {
        let cache = tempfile::tempdir().unwrap();
        let folder = lay_out(cache.path()).unwrap();
        for kind in [FileKind::Scene, FileKind::Study, FileKind::Map] {
            let names: Vec<_> = of_kind(kind).map(|file| file.name()).collect();
            let in_folder = fs::read_dir(root().join(kind.folder()));
            let written = in_folder.unwrap().map(|entry| entry.unwrap().path());
            let of_kind = |path: &PathBuf| {
                path.is_file() && FileKind::of(&fs::read_to_string(path).unwrap()) == Some(kind)
            };
            assert_eq!(names.len(), written.filter(of_kind).count(), "{names:?}");
            assert!(!names.is_empty());
        }
        for scene in of_kind(FileKind::Scene).chain(scenes_for_studies()) {
            let path = folder.join(scene.path);
            let file: SceneFile = scene_file::read(&path).unwrap();
            if let Some(reference) = file.training.reference {
                Model::load(&path.parent().unwrap().join(reference)).unwrap();
            }
        }
        for (name, kind) in models() {
            let model = Model::load(&folder.join("models").join(name)).unwrap();
            assert_eq!(model.manifest().kind.to_string(), kind);
        }
        assert!(models().count() > 0);
    }
}
