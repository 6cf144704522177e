//! An observation model whose sense of azimuth is off, by a smooth function of the azimuth that each object has of its own.
//!
//! ```text
//! p(m(z) | e, b, x_rel) = p(m(z) | e, x_rel turned by s phi(azimuth)^T b),   b ~ N(0, I)
//! ```
//!
//! A model errs along the curve that the measurement draws as the azimuth grows, and alike in neighbouring views of an object: a
//! discrepancy in the sense of Kennedy and O'Hagan (2001), not noise. As `b` stands beside `e` in the latent, many views from one side
//! tell no more than that discrepancy lets them. Of a pair of views, both are turned by it.

use crate::settings::AzimuthDiscrepancy;
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::periodic::{self, FEATURES};
use vantage_model::{
    AnswerError, FirstView, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
    PairLinearization, PairModel, Periodic, ViewpointDerivative,
};

/// A variance that says nothing.
const UNKNOWN: f64 = 1e150;

/// A model with its discrepancy; the latent is that of the model, and then `b`.
pub struct Discrepant<'m, M: ?Sized> {
    model: &'m M,
    sigma: f64,
    functions: Periodic,
}

impl<'m, M: ObservationModel + ?Sized> Discrepant<'m, M> {
    /// Of `model`.
    pub fn new(model: &'m M, discrepancy: &AzimuthDiscrepancy) -> Self {
        let AzimuthDiscrepancy { sigma, concentration } = *discrepancy;
        Self { model, sigma, functions: Periodic::new(concentration) }
    }

    /// The model's own latent, and from where it sees.
    pub fn within(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> (DVector<f64>, Viewpoint) {
        let (own, off) = self.off(latent, viewpoint);
        (own, viewpoint.turned(off.angle))
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

impl Off {
    /// The derivatives by the coefficients, `[M x FEATURES]`, and by the viewpoint, of a prediction whose derivative by the `turned`
    /// viewpoint is known.
    fn chained(
        &self,
        viewpoint: &Viewpoint,
        turned: &Viewpoint,
        by_turned: &ViewpointDerivative,
    ) -> (DMatrix<f64>, ViewpointDerivative) {
        let by_angle = by_turned.by_azimuth(turned);
        let by_coefficients =
            DMatrix::from_fn(by_angle.len(), FEATURES, |i, j| by_angle[i] * self.by_coefficients[j]);
        let by_azimuth = by_angle * (1.0 + self.by_azimuth);
        let by_upright = by_turned.by_upright();
        let of_viewpoint = ViewpointDerivative::by_azimuth_and_upright(viewpoint, &by_azimuth, &by_upright);
        (by_coefficients, of_viewpoint)
    }
}

/// `[left | right]`.
pub(crate) fn beside(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut whole = DMatrix::zeros(left.nrows(), left.ncols() + right.ncols());
    whole.columns_mut(0, left.ncols()).copy_from(left);
    whole.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    whole
}

/// What a view tells of a latent, and of so many numbers more nothing.
pub(crate) fn with_unknown(latent: LatentGaussian, more: usize) -> LatentGaussian {
    let LatentGaussian { mean, variance } = latent;
    let dim = mean.len() + more;
    LatentGaussian {
        mean: mean.resize_vertically(dim, 0.0),
        variance: variance.resize_vertically(dim, UNKNOWN),
    }
}

impl<M: ObservationModel + ?Sized> ObservationModel for Discrepant<'_, M> {
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
        Ok(with_unknown(self.model.encode(crop, viewpoint)?, FEATURES))
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let (own, off) = self.off(latent, viewpoint);
        self.model.predict(&own, &viewpoint.turned(off.angle))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let (own, off) = self.off(latent, viewpoint);
        let turned = viewpoint.turned(off.angle);
        let Linearization { mean, d_latent, d_viewpoint } = self.model.linearize(&own, &turned)?;
        let (by_coefficients, d_viewpoint) = off.chained(viewpoint, &turned, &d_viewpoint);
        Ok(Linearization { mean, d_latent: beside(&d_latent, &by_coefficients), d_viewpoint })
    }
}

impl<M: PairModel + ?Sized> PairModel for Discrepant<'_, M> {
    fn pair_noise(&self) -> &MeasurementNoise {
        self.model.pair_noise()
    }

    fn predict_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<DVector<f64>, AnswerError> {
        let (own, off) = self.off(latent, first.viewpoint);
        let (_, second_off) = self.off(latent, second);
        let first = FirstView { viewpoint: &first.viewpoint.turned(off.angle), ..first };
        self.model.predict_pair(&own, first, &second.turned(second_off.angle))
    }

    fn linearize_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<PairLinearization, AnswerError> {
        let (own, first_off) = self.off(latent, first.viewpoint);
        let (_, second_off) = self.off(latent, second);
        let [first_turned, second_turned] =
            [first.viewpoint.turned(first_off.angle), second.turned(second_off.angle)];
        let turned = FirstView { viewpoint: &first_turned, ..first };
        let at = self.model.linearize_pair(&own, turned, &second_turned)?;
        let (by_first, d_first_viewpoint) =
            first_off.chained(first.viewpoint, &first_turned, &at.d_first_viewpoint);
        let (by_second, d_second_viewpoint) =
            second_off.chained(second, &second_turned, &at.d_second_viewpoint);
        let d_latent = beside(&at.d_latent, &(by_first + by_second));
        Ok(PairLinearization { d_latent, d_first_viewpoint, d_second_viewpoint, ..at })
    }
}
