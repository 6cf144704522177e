//! An observation model whose sense of azimuth is off, by a smooth function of the azimuth that each object has of its own.
//!
//! ```text
//! p(m(z) | e, b, x_rel) = p(m(z) | e, x_rel turned by s phi(azimuth)^T b),   b ~ N(0, I)
//! ```
//!
//! A model errs along the curve that the measurement draws as the azimuth grows, and alike in neighbouring views of an object: a
//! discrepancy in the sense of Kennedy and O'Hagan (2001), not noise. As `b` stands beside `e` in the latent, many views from one side
//! tell no more than that discrepancy lets them.

use crate::settings::AzimuthDiscrepancy;
use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::periodic::{self, FEATURES};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, Periodic,
    ViewpointDerivative,
};

/// A variance that says nothing.
const UNKNOWN: f64 = 1e150;

/// A model with its discrepancy; the latent is that of the model, and then `b`.
pub struct Discrepant<'m> {
    model: &'m dyn ObservationModel,
    sigma: f64,
    functions: Periodic,
}

impl<'m> Discrepant<'m> {
    /// Of `model`.
    pub fn new(model: &'m dyn ObservationModel, discrepancy: &AzimuthDiscrepancy) -> Self {
        let AzimuthDiscrepancy { sigma, concentration } = *discrepancy;
        Self { model, sigma, functions: Periodic::new(concentration) }
    }

    /// The model's own latent, and by how much the azimuth is off with the derivative of that by the azimuth and by `b`.
    fn off(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> (DVector<f64>, Off) {
        let own = self.model.latent_dim();
        let phi = self.functions.features(viewpoint.azimuth()).map(|x| x * self.sigma);
        let along =
            |features: &[f64; FEATURES]| latent.iter().skip(own).zip(features).map(|(b, x)| b * x).sum();
        let off =
            Off { angle: along(&phi), by_azimuth: along(&periodic::derivative(&phi)), by_coefficients: phi };
        (latent.rows(0, own).into_owned(), off)
    }
}

/// By how much the azimuth is off, radians, and its derivatives.
struct Off {
    angle: f64,
    by_azimuth: f64,
    by_coefficients: [f64; FEATURES],
}

impl ObservationModel for Discrepant<'_> {
    fn latent_dim(&self) -> usize {
        self.model.latent_dim() + FEATURES
    }

    fn noise(&self) -> &MeasurementNoise {
        self.model.noise()
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.model.measure(crop)
    }

    /// Of the discrepancy a single view tells nothing.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let LatentGaussian { mean, variance } = self.model.encode(crop, viewpoint)?;
        let dim = mean.len() + FEATURES;
        Ok(LatentGaussian {
            mean: mean.resize_vertically(dim, 0.0),
            variance: variance.resize_vertically(dim, UNKNOWN),
        })
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let (own, off) = self.off(latent, viewpoint);
        self.model.predict(&own, &viewpoint.turned(off.angle))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let (own, off) = self.off(latent, viewpoint);
        let turned = viewpoint.turned(off.angle);
        let Linearization { mean, d_latent, d_viewpoint } = self.model.linearize(&own, &turned)?;
        let by_angle = d_viewpoint.by_azimuth(&turned);
        let mut whole = DMatrix::zeros(mean.len(), d_latent.ncols() + FEATURES);
        whole.columns_mut(0, d_latent.ncols()).copy_from(&d_latent);
        for (i, x) in off.by_coefficients.iter().enumerate() {
            whole.set_column(d_latent.ncols() + i, &(&by_angle * *x));
        }
        // d azimuth = cos d(sin) - sin d(cos), by the first two coordinates alone.
        let (sin, cos) = libm::sincos(viewpoint.azimuth());
        let by_azimuth = by_angle * (1.0 + off.by_azimuth);
        let mut by_coordinates = DMatrix::zeros(mean.len(), CONDITIONING);
        by_coordinates.set_column(0, &(&by_azimuth * -sin));
        by_coordinates.set_column(1, &(&by_azimuth * cos));
        for tail in 2 * HARMONICS..CONDITIONING {
            by_coordinates.set_column(tail, &d_viewpoint.by_coordinates().column(tail));
        }
        Ok(Linearization { mean, d_latent: whole, d_viewpoint: ViewpointDerivative::new(by_coordinates) })
    }
}
