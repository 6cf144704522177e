//! A model of any kind, loaded from its folder and run by tract.

use crate::embedding_model::EmbeddingModel;
use crate::error::ModelError;
use crate::folder::ModelFolder;
use crate::manifest::Manifest;
use crate::predictive_model::PredictiveModel;
use crate::role::{Kind, Role};
use crate::turning_model::TurningModel;
use crate::viewing::Viewing;
use crate::viewpoint_model::ViewpointModel;
use nalgebra::DVector;
use std::collections::BTreeSet;
use std::path::Path;
use vantage_dataset::{Crop, InstanceId, Viewpoint};
use vantage_model::{LatentGaussian, PairModel};

/// What a model folder holds.
#[derive(Debug)]
pub enum Model {
    /// `p(z | e, x_rel)` of Eq. 10.
    ViewpointDependent(ViewpointModel),
    /// `p(z' | z, e, Delta X)` of Eq. 15-20, its latent turning with the object.
    Turning(TurningModel),
    /// The same with a latent that does not turn, or of camera motions: it tells no look from a viewpoint alone.
    ViewpointPredictive(PredictiveModel),
    /// Numbers to cluster and retrieve by.
    Embedding(EmbeddingModel),
}

impl Model {
    /// Loads a folder as [`train`](crate::train), or anyone else, wrote it: see `docs/models.md`.
    ///
    /// Nothing in the folder is trusted: versions, sizes, names, shapes, operators, finite weights and hashes are
    /// checked, external data is refused, and the canary must come out as it did where the model was made.
    pub fn load(folder: &Path) -> Result<Self, ModelError> {
        let folder = ModelFolder::load(folder)?;
        Ok(match folder.manifest.kind {
            Kind::ViewpointDependent => Model::ViewpointDependent(ViewpointModel::new(folder)),
            Kind::ViewpointPredictive => {
                let model = PredictiveModel(folder);
                match TurningModel::layout(&model) {
                    Some(layout) => Model::Turning(TurningModel::new(model, layout)),
                    None => Model::ViewpointPredictive(model),
                }
            }
            Kind::Embedding => Model::Embedding(EmbeddingModel(folder)),
        })
    }

    /// What of one crop says which object it shows: numbers to cluster and retrieve by.
    ///
    /// The mean of the latent after this one view, without what turns with the object's heading where the model knows
    /// that: see [`Latent::steady`](crate::Latent::steady). The encoder of a viewpoint-dependent model needs the
    /// crop's viewpoint, the others do not look at it.
    pub fn embed(&self, crop: &Crop, viewpoint: Option<&Viewpoint>) -> Result<Vec<f64>, ModelError> {
        let after = |factor: LatentGaussian| {
            let latent = self.manifest().latent;
            latent.steady(&LatentGaussian::posterior(latent.dimension, &[factor]).mean)
        };
        match self {
            Model::ViewpointDependent(model) => {
                let viewpoint = viewpoint.ok_or(ModelError::NoViewpoint)?;
                Ok(after(model.factor(crop, viewpoint)?))
            }
            Model::Turning(TurningModel { model, .. }) | Model::ViewpointPredictive(model) => {
                Ok(after(model.encode(crop)?))
            }
            Model::Embedding(model) => {
                Ok(self.manifest().latent.steady(&DVector::from_vec(model.embed(crop)?)))
            }
        }
    }

    /// The model as one of looks from viewpoints; `None` of embeddings, and of predictive models whose latent does not turn
    /// with the object.
    pub fn viewing(&self) -> Option<&dyn Viewing> {
        match self {
            Model::ViewpointDependent(model) => Some(model),
            Model::Turning(model) => Some(model),
            Model::ViewpointPredictive(_) | Model::Embedding(_) => None,
        }
    }

    /// The model as one of pairs of views, Eq. 15; of those with [`Model::viewing`], the viewpoint-predictive ones have it.
    pub fn pairs(&self) -> Option<&dyn PairModel> {
        match self {
            Model::Turning(model) => Some(model),
            Model::ViewpointDependent(_) | Model::ViewpointPredictive(_) | Model::Embedding(_) => None,
        }
    }

    /// Where the model came from, and what it holds.
    pub fn manifest(&self) -> &Manifest {
        &self.folder().manifest
    }

    /// BLAKE3 of the manifest, which holds the hashes of all other files: the model's identity.
    pub fn hash(&self) -> &str {
        &self.folder().hash
    }

    /// The instances that it was trained or calibrated on, none of which may be scored.
    pub fn training_instances(&self) -> &BTreeSet<InstanceId> {
        &self.folder().training_instances
    }

    /// Runs a graph once on its canary's input: something to time.
    pub fn replay(&self, role: Role) -> Result<(), ModelError> {
        self.folder().replay(role)
    }

    fn folder(&self) -> &ModelFolder {
        match self {
            Model::ViewpointDependent(ViewpointModel { folder, .. }) => folder,
            Model::Turning(TurningModel { model: PredictiveModel(folder), .. }) => folder,
            Model::ViewpointPredictive(PredictiveModel(folder)) => folder,
            Model::Embedding(EmbeddingModel(folder)) => folder,
        }
    }
}
