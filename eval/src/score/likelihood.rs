//! `log p(m(z) | e, x_rel)` of one crop, over viewpoints.

use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{AnswerError, ObservationModel, student_t};

/// One crop, asked from where it was taken of an object whose latent is known.
pub struct Likelihood<'a> {
    model: &'a dyn ObservationModel,
    latent: &'a DVector<f64>,
    measured: DVector<f64>,
}

impl<'a> Likelihood<'a> {
    /// Of a crop.
    pub fn new(
        model: &'a dyn ObservationModel,
        latent: &'a DVector<f64>,
        crop: &Crop,
    ) -> Result<Self, AnswerError> {
        Ok(Self { model, latent, measured: model.measure(crop)? })
    }

    /// At a viewpoint, nats, but for a constant; `None` where the model has no answer.
    pub fn at(&self, viewpoint: &Viewpoint) -> Option<f64> {
        let squared = self.whitened_residual(viewpoint)?.norm_squared();
        Some(-student_t::loss(squared, self.measured.len(), self.model.noise().degrees_of_freedom()))
    }

    /// `log p(m(z) | e, x)` at a viewpoint, nats.
    pub(super) fn log_density(&self, viewpoint: &Viewpoint) -> Option<f64> {
        let squared = self.whitened_residual(viewpoint)?.norm_squared();
        let log_det = self.sqrt_information().diagonal().iter().map(|&r| libm::log(r)).sum();
        let nu = self.model.noise().degrees_of_freedom();
        Some(student_t::log_density(squared, self.measured.len(), nu, log_det))
    }

    /// `R (m(z) - m(e, x))`, `[d_m]`.
    pub fn whitened_residual(&self, viewpoint: &Viewpoint) -> Option<DVector<f64>> {
        let predicted = self.model.predict(self.latent, viewpoint).ok()?;
        Some(self.sqrt_information() * (&self.measured - predicted))
    }

    /// `d m / d azimuth`, `[d_m]`, per radian, and `R`.
    pub(super) fn by_azimuth(&self, viewpoint: &Viewpoint) -> Option<(DVector<f64>, &DMatrix<f64>)> {
        let at = self.model.linearize(self.latent, viewpoint).ok()?;
        Some((at.d_viewpoint.by_azimuth(viewpoint), self.sqrt_information()))
    }

    fn sqrt_information(&self) -> &DMatrix<f64> {
        self.model.noise().sqrt_information()
    }
}
