//! The observation model of Eq. 8: a discrete class in place of the latent.

use crate::{AnswerError, MeasurementNoise, ViewpointDerivative};
use nalgebra::DVector;
use vantage_dataset::{Crop, Viewpoint};

/// `p(m(z) | c, x_rel)`, M measured numbers and C classes.
pub trait ClassModel: Send + Sync {
    /// C.
    fn classes(&self) -> usize;

    /// The distribution of `m(z) - h(c, x_rel)`; one number of degrees of freedom for all classes.
    fn noise(&self, class: usize) -> &MeasurementNoise;

    /// `m(z)`, `[M]`: the reduced measurement of a crop.
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError>;

    /// `h(c, x_rel)`, `[M]`, and its derivative to the viewpoint.
    fn linearize(&self, class: usize, viewpoint: &Viewpoint) -> (DVector<f64>, ViewpointDerivative);
}
