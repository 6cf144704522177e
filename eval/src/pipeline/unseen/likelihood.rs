//! `log p(m(z) | e, x_rel)` of one crop, over viewpoints.

use crate::exit::BenchError;
use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Viewpoint};
use vantage_learn::ViewpointModel;

/// One crop, asked from where it was taken of an object whose latent is known.
pub struct Likelihood<'a> {
    model: &'a ViewpointModel,
    latent: &'a DVector<f64>,
    measured: DVector<f64>,
    sqrt_information: DMatrix<f64>,
}

impl<'a> Likelihood<'a> {
    /// Of a crop.
    pub fn new(model: &'a ViewpointModel, latent: &'a DVector<f64>, crop: &Crop) -> Result<Self, BenchError> {
        let measured = model.measure(crop)?;
        Ok(Self { model, latent, measured, sqrt_information: model.noise().sqrt_information() })
    }

    /// At a viewpoint, nats, but for a constant; `None` where the model has no answer.
    pub fn at(&self, viewpoint: &Viewpoint) -> Option<f64> {
        let squared = self.whitened_residual(viewpoint)?.norm_squared();
        let nu = self.model.noise().degrees_of_freedom;
        Some(-0.5 * (nu + self.measured.len() as f64) * libm::log1p(squared / nu))
    }

    /// `R (m(z) - m(e, x))`, `[d_m]`.
    pub(super) fn whitened_residual(&self, viewpoint: &Viewpoint) -> Option<DVector<f64>> {
        let predicted = self.model.predict(self.latent, &viewpoint.conditioning()).ok()?;
        Some(&self.sqrt_information * (&self.measured - predicted))
    }

    /// `d m / d azimuth`, `[d_m]`, per radian, and `R`.
    pub(super) fn by_azimuth(&self, viewpoint: &Viewpoint) -> Option<(DVector<f64>, &DMatrix<f64>)> {
        let x = viewpoint.conditioning();
        let at = self.model.linearize(self.latent, &x).ok()?;
        Some((at.d_conditioning * conditioning_by_azimuth(&x), &self.sqrt_information))
    }
}

/// The derivative of [`Viewpoint::conditioning`] by the azimuth.
fn conditioning_by_azimuth(x: &[f64; CONDITIONING]) -> DVector<f64> {
    let mut derivative = DVector::zeros(CONDITIONING);
    for m in 1..=HARMONICS {
        derivative[2 * m - 2] = -(m as f64) * x[2 * m - 1];
        derivative[2 * m - 1] = m as f64 * x[2 * m - 2];
    }
    derivative
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn the_derivative_by_azimuth_is_that_of_a_turn() {
        let direction = Vector3::new(0.5, -0.7, 0.4).normalize();
        let viewpoint = Viewpoint { direction, roll: 0.1, log_distance: 0.7 };
        let (step, x) = (1e-6, viewpoint.conditioning());
        let (ahead, behind) = (viewpoint.turned(step).conditioning(), viewpoint.turned(-step).conditioning());
        let derivative = conditioning_by_azimuth(&x);
        for i in 0..CONDITIONING {
            let measured = (ahead[i] - behind[i]) / (2.0 * step);
            assert!((derivative[i] - measured).abs() < 1e-8, "{i}: {} {measured}", derivative[i]);
        }
    }
}
