//! Trained trunks that several trainings share.

use crate::architecture::Architecture;
use crate::spec::TrainingSpec;
use crate::train::error::TrainError;
use crate::train::run::checkpoint::{self, Checkpoint, State};
use crate::train::run::curve::Curve;
use crate::train::run::files;
use crate::train::run::origin::Origin;
use crate::train::run::progress::Stage;
use std::path::{Path, PathBuf};
use vantage_dataset::Seed;

/// The place of one training's trunk.
pub(crate) struct TrunkStore {
    folder: PathBuf,
    /// Hash of everything that decides what stage 1 does.
    key: String,
    steps: usize,
}

impl TrunkStore {
    /// In a folder of trunks.
    pub(crate) fn new(
        folder: &Path,
        origin: &Origin,
        spec: &TrainingSpec,
        architecture: &Architecture,
        seed: Seed,
    ) -> Self {
        let task = format!("{:?} {:?}", spec.traits().task, spec.predictive.motion);
        let sizes =
            (&architecture.trunk, architecture.features, architecture.measurement, architecture.components);
        let descent = (
            spec.trunk_steps,
            spec.trunk_batch,
            spec.learning_rate,
            spec.trunk_instance_weight,
            spec.trunk_augmentation,
        );
        let decides =
            (env!("CARGO_PKG_VERSION"), &origin.data_hash, &origin.provenance, task, sizes, descent, seed);
        let json = serde_json::to_vec(&decides).expect("numbers and strings become JSON");
        let key = blake3::hash(&json).to_hex().to_string();
        Self { folder: folder.join(&key), key, steps: spec.trunk_steps as usize }
    }

    /// The trunk that an earlier training left; a damaged one counts as none.
    pub(crate) fn find(&self) -> Option<Checkpoint> {
        let found = Checkpoint::read(&self.folder, &self.key).ok().flatten()?;
        (found.state.step == self.steps).then_some(found)
    }

    /// Keeps a trained trunk, with its loss curve.
    pub(crate) fn keep(&self, trunk: Vec<u8>, curve: &Curve) -> Result<(), TrainError> {
        if self.folder.join(checkpoint::CHECKPOINT).exists() {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder).map_err(|error| files::unwritable(&self.folder, &error))?;
        let state =
            State { key: self.key.clone(), stage: Stage::Trunk, step: self.steps, curve: curve.clone() };
        Checkpoint { state, trunk, autoencoder: Vec::new(), optimizer: Vec::new() }.write(&self.folder)
    }
}
