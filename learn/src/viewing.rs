//! What viewpoint-dependent and viewpoint-predictive models have in common: an object's look, from a latent and a viewpoint.

use crate::error::ModelError;
use crate::latent::{Latent, LatentGaussian, LatentLayout};
use crate::predictive_model::PredictiveModel;
use crate::residual::ResidualNoise;
use crate::role::{Convention, OBJECT_CENTRED_CHANGE, Role};
use crate::viewpoint_model::{Linearization, ViewpointModel};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Viewpoint};

/// `q(e | z, x_rel)` and `p(m | e, x_rel)`, latents in the object's frame.
pub trait Viewing: Sync {
    /// The latent.
    fn latent(&self) -> Latent;

    /// Noise of `m(z) - m(e, x)`.
    fn noise(&self) -> &ResidualNoise;

    /// `m(z)`, `[d_m]`.
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError>;

    /// The factor `q` of one view on the latent.
    fn encode_view(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError>;

    /// `m(e, x)`, `[d_m]`, of a latent and a viewpoint's conditioning.
    fn predict(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError>;

    /// The same with its derivatives.
    fn linearize(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Linearization, ModelError>;

    /// `m(e, x)`, `[d_m]`.
    fn predict_view(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, ModelError> {
        self.predict(latent, &viewpoint.conditioning())
    }

    /// The crop expected; `None` of a model without the graph for that.
    fn reconstruct_view(
        &self,
        latent: &DVector<f64>,
        viewpoint: &Viewpoint,
    ) -> Option<Result<Crop, ModelError>>;

    /// `d m / d azimuth`, `[d_m]`, per radian.
    fn by_azimuth(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, ModelError> {
        let x = viewpoint.conditioning();
        Ok(self.linearize(latent, &x)?.d_conditioning * conditioning_by_azimuth(&x))
    }
}

impl Viewing for &ViewpointModel {
    fn latent(&self) -> Latent {
        ViewpointModel::latent(self)
    }

    fn noise(&self) -> &ResidualNoise {
        ViewpointModel::noise(self)
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        ViewpointModel::measure(self, crop)
    }

    fn encode_view(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        self.encode(crop, viewpoint)
    }

    fn predict(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError> {
        ViewpointModel::predict(self, latent, x)
    }

    fn linearize(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Linearization, ModelError> {
        ViewpointModel::linearize(self, latent, x)
    }

    fn reconstruct_view(
        &self,
        latent: &DVector<f64>,
        viewpoint: &Viewpoint,
    ) -> Option<Result<Crop, ModelError>> {
        self.has(Role::Image).then(|| self.reconstruct(latent, &viewpoint.conditioning()))
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

/// A viewpoint-predictive model whose latent turns: seen from a viewpoint is a change of viewpoint from azimuth 0, without a
/// first view.
pub(crate) struct Turning<'a> {
    model: &'a PredictiveModel,
    layout: LatentLayout,
    /// No measurement of a first view, `[d_m]`.
    nothing: DVector<f64>,
}

impl<'a> Turning<'a> {
    /// `None` where the latent does not turn, or the model is told of the camera's motion.
    pub(crate) fn new(model: &'a PredictiveModel) -> Option<Self> {
        let centred = model.convention() == Convention::ObjectCentredChange;
        let layout = model.latent().steerable.filter(|_| centred)?;
        Some(Self { model, layout, nothing: DVector::zeros(model.measurement_dim()) })
    }
}

/// The harmonics, nothing of the first view's upright part, and that of the viewpoint.
fn change_from_azimuth_0(x: &[f64; CONDITIONING]) -> [f64; OBJECT_CENTRED_CHANGE] {
    let mut change = [0.0; OBJECT_CENTRED_CHANGE];
    change[..2 * HARMONICS].copy_from_slice(&x[..2 * HARMONICS]);
    change[CONDITIONING..].copy_from_slice(&x[2 * HARMONICS..]);
    change
}

impl Viewing for Turning<'_> {
    fn latent(&self) -> Latent {
        self.model.latent()
    }

    fn noise(&self) -> &ResidualNoise {
        self.model.noise()
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        self.model.measure(crop)
    }

    fn encode_view(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        let LatentGaussian { mean, variance } = self.model.encode(crop)?;
        Ok(LatentGaussian { mean: self.layout.turned(&mean, viewpoint.azimuth()), variance })
    }

    fn predict(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError> {
        self.model.predict(latent, &self.nothing, &change_from_azimuth_0(x))
    }

    fn linearize(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Linearization, ModelError> {
        let at = self.model.linearize(latent, &self.nothing, &change_from_azimuth_0(x))?;
        let mut d_conditioning = DMatrix::zeros(at.measurement.len(), CONDITIONING);
        d_conditioning.columns_mut(0, 2 * HARMONICS).copy_from(&at.d_change.columns(0, 2 * HARMONICS));
        let upright = CONDITIONING - 2 * HARMONICS;
        let of_view = at.d_change.columns(CONDITIONING, upright);
        d_conditioning.columns_mut(2 * HARMONICS, upright).copy_from(&of_view);
        Ok(Linearization { measurement: at.measurement, d_latent: at.d_latent, d_conditioning })
    }

    fn reconstruct_view(
        &self,
        latent: &DVector<f64>,
        viewpoint: &Viewpoint,
    ) -> Option<Result<Crop, ModelError>> {
        let change = change_from_azimuth_0(&viewpoint.conditioning());
        self.model.has(Role::Image).then(|| self.model.reconstruct(latent, &self.nothing, &change))
    }
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
