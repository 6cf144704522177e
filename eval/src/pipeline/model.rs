//! Stage `model`: the scene's committed model, one that the user names, or one trained here.

use super::{Pipeline, TractModel};
use crate::exit::BenchError;
use crate::scene_file;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use vantage_dataset::InstanceId;
use vantage_learn::ViewpointModel;

/// File in a model's folder that lists the instances it was trained or calibrated on, so that none of them is scored.
pub const TRAINING_INSTANCES: &str = "training_instances.txt";

/// What a model's manifest calls the hash of the conditions its views were made under.
pub const VIEW_CONDITIONS: &str = "view_conditions";

/// A model ready for the estimator.
pub struct LoadedModel {
    /// The model.
    pub model: TractModel,
    /// Its folder.
    pub folder: PathBuf,
    /// What identifies it.
    pub hash: String,
    /// Instances it has seen.
    pub seen: BTreeSet<InstanceId>,
}

impl LoadedModel {
    /// Refuses to score instances that the model has seen.
    pub fn check_unseen(&self, scored: impl IntoIterator<Item = InstanceId>) -> Result<(), BenchError> {
        match scored.into_iter().find(|instance| self.seen.contains(instance)) {
            Some(instance) => Err(BenchError::Leak { instance, folder: self.folder.clone() }),
            None => Ok(()),
        }
    }
}

/// Loads the model in `folder`, or trains one where that is `None`.
pub fn model(pipeline: &Pipeline, folder: Option<&Path>) -> Result<LoadedModel, BenchError> {
    match folder {
        Some(folder) => load(pipeline, folder),
        #[cfg(feature = "train")]
        None => load(pipeline, &super::training::trained(pipeline)?),
        #[cfg(not(feature = "train"))]
        None => Err(BenchError::CannotTrain),
    }
}

pub(super) fn load(pipeline: &Pipeline, folder: &Path) -> Result<LoadedModel, BenchError> {
    let model = ViewpointModel::load(folder)?;
    let trained_under = model.manifest().training.provenance.get(VIEW_CONDITIONS);
    if trained_under != Some(&scene_file::hash(&pipeline.scene.view_conditions())?) {
        pipeline.progress.note(&format!(
            "note: the model in {} was trained under other views than this scene's (families, light, camera, \
             viewpoints or their number differ); it is scored as it is",
            folder.display()
        ));
    }
    Ok(LoadedModel {
        hash: model.hash().to_owned(),
        seen: seen_instances(folder, model.manifest().training.instances)?,
        model: TractModel::new(model).map_err(vantage_slam::EstimateError::from)?,
        folder: folder.to_owned(),
    })
}

/// The list, which has to hold all `trained_on` training instances and some that calibrated the noise.
fn seen_instances(folder: &Path, trained_on: usize) -> Result<BTreeSet<InstanceId>, BenchError> {
    let path = folder.join(TRAINING_INSTANCES);
    let invalid = |reason: String| BenchError::TrainingInstances { path: path.clone(), reason };
    let text = std::fs::read_to_string(&path).map_err(|error| invalid(error.to_string()))?;
    let id = |line: &str| {
        let id = u64::from_str_radix(line, 16).ok().filter(|_| line.len() == 16);
        id.map(InstanceId).ok_or_else(|| invalid(format!("got {line:?}, expected 16 hexadecimal digits")))
    };
    let seen: BTreeSet<InstanceId> = text.lines().map(id).collect::<Result<_, _>>()?;
    if seen.len() <= trained_on {
        return Err(invalid(format!("got {} instances, expected more than {trained_on}", seen.len())));
    }
    Ok(seen)
}
