//! `log p(m(z) | e, x_rel)` of one crop, over viewpoints.

use super::bound::{student_t_log_density, student_t_log_kernel};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Crop, Viewpoint};
use vantage_learn::{ModelError, Viewing};

/// One crop, asked from where it was taken of an object whose latent is known.
pub struct Likelihood<'a> {
    model: &'a dyn Viewing,
    latent: &'a DVector<f64>,
    measured: DVector<f64>,
    sqrt_information: DMatrix<f64>,
}

impl<'a> Likelihood<'a> {
    /// Of a crop.
    pub fn new(model: &'a dyn Viewing, latent: &'a DVector<f64>, crop: &Crop) -> Result<Self, ModelError> {
        let measured = model.measure(crop)?;
        Ok(Self { model, latent, measured, sqrt_information: model.noise().sqrt_information() })
    }

    /// At a viewpoint, nats, but for a constant; `None` where the model has no answer.
    pub fn at(&self, viewpoint: &Viewpoint) -> Option<f64> {
        let squared = self.whitened_residual(viewpoint)?.norm_squared();
        let nu = self.model.noise().degrees_of_freedom;
        Some(student_t_log_kernel(squared, self.measured.len(), nu))
    }

    /// `log p(m(z) | e, x)` at a viewpoint, nats.
    pub(super) fn log_density(&self, viewpoint: &Viewpoint) -> Option<f64> {
        let squared = self.whitened_residual(viewpoint)?.norm_squared();
        let log_det = self.sqrt_information.diagonal().iter().map(|&r| libm::log(r)).sum();
        let nu = self.model.noise().degrees_of_freedom;
        Some(student_t_log_density(squared, self.measured.len(), nu, log_det))
    }

    /// `R (m(z) - m(e, x))`, `[d_m]`.
    pub fn whitened_residual(&self, viewpoint: &Viewpoint) -> Option<DVector<f64>> {
        let predicted = self.model.predict_view(self.latent, viewpoint).ok()?;
        Some(&self.sqrt_information * (&self.measured - predicted))
    }

    /// `d m / d azimuth`, `[d_m]`, per radian, and `R`.
    pub(super) fn by_azimuth(&self, viewpoint: &Viewpoint) -> Option<(DVector<f64>, &DMatrix<f64>)> {
        Some((self.model.by_azimuth(self.latent, viewpoint).ok()?, &self.sqrt_information))
    }
}
