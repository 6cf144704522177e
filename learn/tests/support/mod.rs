//! What the tests share: a tiny training, and the model it gives.

pub mod synthetic;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_learn::{
    Model, Progress, TrainError, Training, TrainingDevice, TrainingSpec, ViewpointModel, train,
};

pub fn tiny_spec() -> TrainingSpec {
    TrainingSpec {
        trunk_steps: 40,
        trunk_batch: 16,
        steps: 120,
        batch: 8,
        views: 4,
        context: 3,
        learning_rate: 5e-3,
        latent_dim: 30,
        pairs_per_harmonic: 2,
        measurement_dim: 6,
        checkpoint_every: 15,
        ..TrainingSpec::default()
    }
}

pub fn training_views() -> ViewSet {
    synthetic::views(Split::Train, 12, 8, 1)
}

pub fn validation_views() -> ViewSet {
    synthetic::views(Split::Validation, 8, 8, 2)
}

/// A training on training and validation views, told to stop wherever `stop` says so; what it told.
pub fn trained(
    [training, validation]: [&ViewSet; 2],
    spec: &TrainingSpec,
    folder: &Path,
    trunks: Option<&Path>,
    stop: impl Fn(&Progress) -> bool,
) -> Result<Vec<Progress>, TrainError> {
    let mut told = Vec::new();
    let mut progress = |progress: &Progress| {
        told.push(progress.clone());
        if stop(progress) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let provenance = &BTreeMap::from([("scene".to_owned(), "a scene".to_owned())]);
    let (seed, device) = (Seed(0), &TrainingDevice::default());
    let asked = Training { training, validation, spec, seed, provenance, folder, trunks, device };
    train(asked, &mut progress)?;
    Ok(told)
}

/// A training in `folder` on the views of [`training_views`] and [`validation_views`].
pub fn tiny_training(
    folder: &Path,
    spec: &TrainingSpec,
    stop: impl Fn(&Progress) -> bool,
) -> Result<Vec<Progress>, TrainError> {
    trained([&training_views(), &validation_views()], spec, folder, None, stop)
}

/// The folder of a model of [`tiny_spec`], trained once for all tests of a binary.
pub fn tiny_model() -> PathBuf {
    static MODEL: OnceLock<TempDir> = OnceLock::new();
    let folder = MODEL.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        tiny_training(folder.path(), &tiny_spec(), |_| false).unwrap();
        folder
    });
    folder.path().to_owned()
}

/// The viewpoint-dependent model in a folder.
pub fn viewpoint_model(folder: &Path) -> ViewpointModel {
    match Model::load(folder).unwrap() {
        Model::ViewpointDependent(model) => model,
        other => panic!("another kind of model: {other:?}"),
    }
}
