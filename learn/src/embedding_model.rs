//! A model that only embeds crops.

use crate::error::ModelError;
use crate::folder::ModelFolder;
use crate::manifest::Manifest;
use crate::role::{Kind, Role};
use std::collections::BTreeSet;
use std::path::Path;
use vantage_dataset::{Crop, InstanceId};

/// A crop's numbers, to cluster and retrieve by: any encoder of images.
pub struct EmbeddingModel(pub(crate) ModelFolder);

impl EmbeddingModel {
    /// Loads a folder as [`Model::load`](crate::Model::load) does, and refuses other kinds of model.
    pub fn load(folder: &Path) -> Result<Self, ModelError> {
        ModelFolder::load_kind(folder, Kind::Embedding).map(Self)
    }

    /// The numbers of a crop, `[latent]`.
    pub fn embed(&self, crop: &Crop) -> Result<Vec<f64>, ModelError> {
        let [mean] = self.0.run(Role::Encoder, [&crop.to_chw()])?;
        Ok(mean.into_iter().map(f64::from).collect())
    }

    /// BLAKE3 of the manifest, which holds the hashes of all other files: the model's identity.
    pub fn hash(&self) -> &str {
        &self.0.hash
    }

    /// Where the model came from, and what it holds.
    pub fn manifest(&self) -> &Manifest {
        &self.0.manifest
    }

    /// The instances that it was trained or calibrated on, none of which may be scored.
    pub fn training_instances(&self) -> &BTreeSet<InstanceId> {
        &self.0.training_instances
    }
}

impl std::fmt::Debug for EmbeddingModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EmbeddingModel({})", self.0.hash)
    }
}
