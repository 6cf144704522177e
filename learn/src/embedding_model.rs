//! A model that only embeds crops.

use crate::error::ModelError;
use crate::folder::ModelFolder;
use crate::role::Role;
use vantage_dataset::Crop;

/// A crop's numbers, to cluster and retrieve by: any encoder of images.
#[derive(Debug)]
pub struct EmbeddingModel(pub(crate) ModelFolder);

impl EmbeddingModel {
    /// The numbers of a crop, `[latent]`.
    pub fn embed(&self, crop: &Crop) -> Result<Vec<f64>, ModelError> {
        let [mean] = self.0.run(Role::Encoder, [&crop.to_chw()])?;
        Ok(mean.into_iter().map(f64::from).collect())
    }
}
