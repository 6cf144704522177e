//! A model of pairs whose first view is measured with noise of its own.
//!
//! ```text
//! y = m(z) - sqrt(share) R^(1/2) n,   n ~ N(0, I)
//! p(y | e, x_rel) = h(e, x_rel) and the rest of the noise,   p(m(z') | y, e, Delta X)
//! ```
//!
//! `R` is the scale of the model's noise: its covariance where that is Gaussian. As `n` stands beside `e` in the latent, all views that are predicted from `y` share it.

use crate::discrepancy::{beside, with_unknown};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{
    AnswerError, FirstView, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
    PairLinearization, PairModel,
};

/// A model with the noise of one first view; the latent is that of the model, and then `n`. Single views are taken to be that first one.
pub struct NoisyFirst<'m> {
    model: &'m dyn PairModel,
    /// `sqrt(share) R^(1/2)`, `[M x M]`.
    own: DMatrix<f64>,
    rest: MeasurementNoise,
}

impl<'m> NoisyFirst<'m> {
    /// Of a share of that scale, from 0 to below 1, under noise that is multiplied by `noise_scale`; refused where the noise is singular or nothing is left of it.
    pub fn new(model: &'m dyn PairModel, share: f64, noise_scale: f64) -> Result<Self, AnswerError> {
        let whiten = model.noise().sqrt_information();
        let singular = AnswerError::NonFinite { what: "inverse of the measurement noise" };
        let own = whiten.clone().try_inverse().ok_or(singular)? * (share.sqrt() * noise_scale);
        let rest = MeasurementNoise::new(whiten / (1.0 - share).sqrt(), model.noise().degrees_of_freedom())?;
        Ok(Self { model, own, rest })
    }

    /// The model's own latent, and what the first view was measured off by.
    fn apart(&self, latent: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let dim = self.model.latent_dim();
        (latent.rows(0, dim).into_owned(), &self.own * latent.rows(dim, self.own.ncols()))
    }
}

impl ObservationModel for NoisyFirst<'_> {
    fn latent_dim(&self) -> usize {
        self.model.latent_dim() + self.own.ncols()
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.rest
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.model.measure(crop)
    }

    /// Of the noise a single view tells nothing.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        Ok(with_unknown(self.model.encode(crop, viewpoint)?, self.own.ncols()))
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let (own, off) = self.apart(latent);
        Ok(self.model.predict(&own, viewpoint)? + off)
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let (own, off) = self.apart(latent);
        let at = self.model.linearize(&own, viewpoint)?;
        Ok(Linearization { mean: at.mean + off, d_latent: beside(&at.d_latent, &self.own), ..at })
    }
}

impl PairModel for NoisyFirst<'_> {
    fn pair_noise(&self) -> &MeasurementNoise {
        self.model.pair_noise()
    }

    fn predict_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<DVector<f64>, AnswerError> {
        let (own, off) = self.apart(latent);
        self.model.predict_pair(&own, FirstView { measurement: &(first.measurement - off), ..first }, second)
    }

    fn linearize_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<PairLinearization, AnswerError> {
        let (own, off) = self.apart(latent);
        let first = FirstView { measurement: &(first.measurement - off), ..first };
        let at = self.model.linearize_pair(&own, first, second)?;
        let by_noise = -(&at.d_first_measurement * &self.own);
        Ok(PairLinearization { d_latent: beside(&at.d_latent, &by_noise), ..at })
    }
}
