//! Stage `embedding`: the embedding that comes with the program, by which rivals compare crops, and its covariances on a scene's validation views.

use super::model::check_unseen;
use super::{ModelRefusal, Pipeline, StageError, code, views};
use crate::supplied;
use std::path::PathBuf;
use vantage_dataset::store::Key;
use vantage_dataset::{InstanceId, Split};
use vantage_learn::Model;
use vantage_learn::readout::{EmbeddingReadout, EmbeddingWeights};

/// Its name among the models that come with the program.
const NAME: &str = "embedding";
const FILE: &str = "embedding.json";

/// A model's numbers, ready to be compared.
pub struct LoadedEmbedding {
    model: Model,
    weights: Option<EmbeddingWeights>,
    folder: PathBuf,
    /// What identifies the model and the views that the covariances are fitted on.
    pub identity: [String; 2],
}

impl LoadedEmbedding {
    /// Numbers of crops, in the basis of the covariances; `None` where the scene has too few validation views for these.
    pub fn readout(&self) -> Option<EmbeddingReadout<'_>> {
        Some(EmbeddingReadout::new(&self.model, self.weights.as_ref()?))
    }

    /// Refuses to score instances that the model has seen.
    pub fn check_unseen(&self, scored: impl IntoIterator<Item = InstanceId>) -> Result<(), StageError> {
        check_unseen(self.model.training_instances(), &self.folder, scored)
    }
}

/// The embedding, and its covariances.
pub fn embedding(pipeline: &Pipeline) -> Result<LoadedEmbedding, StageError> {
    let folder = supplied::model(NAME, pipeline.cache.folder())?;
    let folder = folder.expect("it comes with the program");
    let model = Model::load(&folder)?;
    let (set, seal) = views(pipeline, Split::Validation, pipeline.file.training.seed, &mut |_| ())?;
    let key = Key::new("embedding", &(code::SCORED, &seal, model.hash()))?;
    let weights = pipeline
        .cache
        .json(&key, FILE, || Ok(EmbeddingWeights::fit(&model, &set).map_err(ModelRefusal::Answer)?))?;
    let identity = [model.hash().to_owned(), seal];
    Ok(LoadedEmbedding { model, weights, folder, identity })
}
