//! An observation model whose prediction is linear in some of its parameters: those of a network's last layer.

use crate::{AnswerError, ObservationModel};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::Viewpoint;

/// `h(e, x_rel) = W phi(e, x_rel)`, `W` of M rows and F columns.
pub trait LastLayer: Sync {
    /// The model as it was trained.
    fn model(&self) -> &dyn ObservationModel;

    /// `phi(e, x_rel)`, `[F]`: what comes into the layer, and a last 1 that its bias is a weight of.
    fn features(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError>;

    /// The model with `W + change` in place of `W`, `[M x F]`.
    fn changed(&self, change: &DMatrix<f64>) -> Result<Box<dyn ObservationModel + '_>, AnswerError>;
}
