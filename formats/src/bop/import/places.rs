//! Where a dataset in BOP's layout has its scenes and models.

use super::files::CAMERA;
use super::images::FOLDERS;
use super::mesh::{INFO, ReadModel, read_models};
use crate::import::{ImportError, ImportReport};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub(super) const GT: &str = "scene_gt.json";
/// Folders of models, the first that is there.
const MODELS: [&str; 4] = ["models", "models_eval", "models_cad", "models_reconst"];
const REMEDY: &str = "name the dataset's folder, that of a split, or that of one scene";
const ANNOTATE: &str = "fetch the annotations, or name a split that has them";
const FETCH_MODELS: &str = "fetch the dataset's models";
/// Scenes without annotations that are named, of one folder.
const NAMED: usize = 10;

/// The scenes of a split, and the models of its objects.
#[derive(Clone, Debug)]
pub struct BopScenes {
    /// The scenes' folders, by name.
    pub scenes: Vec<PathBuf>,
    /// Whether the object of a scene whose images show one at most is taken to stand still, so that it tells the camera's pose; `false` at
    /// first. Where it turned before the camera, its views are right, and the robot's way is none.
    pub lone_object_stands: bool,
    pub(super) models: BTreeMap<u32, ReadModel>,
    /// The file that lists the models.
    pub(super) models_info: PathBuf,
    pub(super) dataset: String,
}

impl BopScenes {
    /// Finds the scenes of `folder`, and reads the models beside them or above. Scenes without annotations are told.
    ///
    /// # Errors
    ///
    /// No scene with annotations or several splits in the folder, no folder of models, and a `models_info.json` that contradicts the
    /// layout.
    pub fn open(folder: &Path, report: &mut ImportReport) -> Result<Self, ImportError> {
        let Found { scenes, bare } = find(folder)?;
        tell_bare(&bare, report);
        let absolute = scenes[0].canonicalize().map_err(ImportError::read(&scenes[0]))?;
        let above: Vec<&Path> = absolute.ancestors().skip(1).take(2).collect();
        let found = above
            .iter()
            .flat_map(|place| MODELS.map(|name| (*place, place.join(name))))
            .find(|(_, models)| models.is_dir());
        let Some((root, models)) = found else { return Err(no_models(&absolute, &above)) };
        let dataset = name_of(root);
        let models_info = models.join(INFO);
        let models = read_models(&models, report)?;
        Ok(Self { scenes, lone_object_stands: false, models, models_info, dataset })
    }
}

/// Folders by name.
struct Found {
    scenes: Vec<PathBuf>,
    /// What looks like a scene and has no annotations.
    bare: Vec<PathBuf>,
}

impl Found {
    fn in_folder(folder: &Path) -> Result<Self, ImportError> {
        let (scenes, others): (Vec<_>, Vec<_>) =
            folders_in(folder)?.into_iter().partition(|scene| scene.join(GT).is_file());
        let bare = others.into_iter().filter(|other| looks_like_scene(other)).collect();
        Ok(Self { scenes, bare })
    }
}

/// The folder itself where it is a scene, the scenes in it, or those of its only split.
fn find(folder: &Path) -> Result<Found, ImportError> {
    if folder.join(GT).is_file() {
        return Ok(Found { scenes: vec![folder.to_owned()], bare: Vec::new() });
    }
    let here = Found::in_folder(folder)?;
    if !here.scenes.is_empty() {
        return Ok(here);
    }
    let (mut splits, mut bare) = (Vec::new(), here.bare);
    for split in folders_in(folder)? {
        let found = Found::in_folder(&split)?;
        bare.extend(found.bare);
        if !found.scenes.is_empty() {
            splits.push((split, found.scenes));
        }
    }
    match splits.len() {
        1 => Ok(Found { scenes: splits.remove(0).1, bare }),
        0 => Err(no_scene(folder, &bare)),
        _ => {
            let names: Vec<String> = splits.iter().map(|(split, _)| name_of(split)).collect();
            let got = format!("several: {}", names.join(", "));
            Err(ImportError::invalid(folder, "splits", got, "one", "name the folder of one of them"))
        }
    }
}

/// That nothing is a scene, or the first that would be one with annotations.
fn no_scene(folder: &Path, bare: &[PathBuf]) -> ImportError {
    let first = if looks_like_scene(folder) { Some(folder) } else { bare.first().map(PathBuf::as_path) };
    let expected = format!("a folder with a {GT}");
    match first {
        Some(scene) => ImportError::invalid(scene, "annotations", format!("no {GT}"), expected, ANNOTATE),
        None => ImportError::invalid(folder, "scenes", "none", expected, REMEDY),
    }
}

/// That no folder of models is where those of a scene may be; without sizes no object is one.
fn no_models(scene: &Path, above: &[&Path]) -> ImportError {
    let places: Vec<String> = above.iter().map(|place| place.display().to_string()).collect();
    let expected = format!("one of {}, in {}", MODELS.join(", "), places.join(" or in "));
    let dataset = above.last().copied().unwrap_or(scene);
    ImportError::invalid(dataset, "models", "no folder of them", expected, FETCH_MODELS)
}

/// Tells of scenes without annotations, those of one folder in one line.
fn tell_bare(bare: &[PathBuf], report: &mut ImportReport) {
    for scenes in bare.chunk_by(|a, b| a.parent() == b.parent()) {
        let names: Vec<String> = scenes.iter().take(NAMED).map(|scene| name_of(scene)).collect();
        let mut why = format!("scenes without {GT}: {}", names.join(", "));
        if scenes.len() > NAMED {
            why += &format!(" and {} more", scenes.len() - NAMED);
        }
        report.skip(scenes[0].parent().unwrap_or(&scenes[0]), why);
    }
}

fn looks_like_scene(folder: &Path) -> bool {
    folder.join(CAMERA).is_file() || FOLDERS.iter().any(|images| folder.join(images).is_dir())
}

fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn folders_in(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let entries = std::fs::read_dir(folder).map_err(ImportError::read(folder))?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>();
    let mut folders = paths.map_err(ImportError::read(folder))?;
    folders.retain(|path| path.is_dir());
    folders.sort();
    Ok(folders)
}
