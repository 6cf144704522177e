//! Models of looks from viewpoints, of a learned latent.

use crate::error::ModelError;
use crate::latent::Latent;
use crate::onnx::error::GraphError;
use nalgebra::DVector;
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{AnswerError, ObservationModel};

/// An observation model whose latent is known by its layout, and which may tell whole crops.
pub trait Viewing: ObservationModel {
    /// The latent.
    fn latent(&self) -> Latent;

    /// The crop expected of a latent from a viewpoint; `None` of a model without the graph for that.
    fn reconstruct(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Option<Result<Crop, AnswerError>>;
}

/// An answer that is not finite costs a detection, anything else the run.
impl From<ModelError> for AnswerError {
    fn from(error: ModelError) -> Self {
        match error {
            ModelError::Run { source: GraphError::NonFiniteOutput { .. }, .. } => {
                AnswerError::NonFinite { what: "output" }
            }
            ModelError::Run { source: GraphError::InputRange { .. }, .. } => {
                AnswerError::NonFinite { what: "input" }
            }
            error => AnswerError::Runtime { message: error.to_string() },
        }
    }
}
