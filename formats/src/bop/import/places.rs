//! Where a dataset in BOP's layout has its scenes and models.

use super::mesh::{ReadModel, read_models};
use crate::import::{ImportError, ImportReport};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub(super) const GT: &str = "scene_gt.json";
/// Folders of models, the first that is there.
const MODELS: [&str; 4] = ["models", "models_eval", "models_cad", "models_reconst"];
const REMEDY: &str = "name the dataset's folder, that of a split, or that of one scene";

/// The scenes of a split, and the models of its objects.
#[derive(Clone, Debug)]
pub struct BopScenes {
    /// The scenes' folders, by name.
    pub scenes: Vec<PathBuf>,
    pub(super) models: BTreeMap<u32, ReadModel>,
    pub(super) dataset: String,
}

impl BopScenes {
    /// Finds the scenes of `folder`, and reads the models beside them or above.
    ///
    /// # Errors
    ///
    /// No scene or several splits in the folder, and a `models_info.json` that contradicts the layout.
    pub fn open(folder: &Path, report: &mut ImportReport) -> Result<Self, ImportError> {
        let scenes = scene_folders(folder)?;
        let absolute = scenes[0].canonicalize().map_err(ImportError::read(&scenes[0]))?;
        let above = absolute.ancestors().skip(1).take(2);
        let models = above
            .flat_map(|place| MODELS.map(|name| (place.to_owned(), place.join(name))))
            .find(|(_, models)| models.is_dir());
        let root = models.as_ref().map_or(absolute.as_path(), |(root, _)| root);
        let dataset = root.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let models = models.map(|(_, models)| read_models(&models, report)).transpose()?;
        Ok(Self { scenes, models: models.unwrap_or_default(), dataset })
    }
}

/// The folder itself where it is a scene, the scenes in it, or those of its only split.
///
/// # Errors
///
/// No scene, or several splits.
pub fn scene_folders(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    if folder.join(GT).is_file() {
        return Ok(vec![folder.to_owned()]);
    }
    let scenes = scenes_in(folder)?;
    if !scenes.is_empty() {
        return Ok(scenes);
    }
    let mut splits = Vec::new();
    for split in folders_in(folder)? {
        let scenes = scenes_in(&split)?;
        if !scenes.is_empty() {
            splits.push((split, scenes));
        }
    }
    match splits.len() {
        1 => Ok(splits.remove(0).1),
        0 => Err(ImportError::invalid(folder, "scenes", "none", format!("a folder with a {GT}"), REMEDY)),
        _ => {
            let name = |split: &Path| split.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let names: Vec<String> = splits.iter().map(|(split, _)| name(split)).collect();
            let got = format!("several: {}", names.join(", "));
            Err(ImportError::invalid(folder, "splits", got, "one", "name the folder of one of them"))
        }
    }
}

fn scenes_in(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    Ok(folders_in(folder)?.into_iter().filter(|scene| scene.join(GT).is_file()).collect())
}

fn folders_in(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let entries = std::fs::read_dir(folder).map_err(ImportError::read(folder))?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>();
    let mut folders = paths.map_err(ImportError::read(folder))?;
    folders.retain(|path| path.is_dir());
    folders.sort();
    Ok(folders)
}
