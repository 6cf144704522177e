//! A Gaussian process per object over the azimuth whose prior mean is a learned model: the object's own views correct what the model
//! says of them, the more the nearer they are.
//!
//! ```text
//! m(z) = h(e, x) + R^-1 S B phi(azimuth) + eps,   e, B ~ N(0, I),   eps ~ t(0, (R^T N^-2 R)^-1)
//! ```
//!
//! `R` is the whitening of the model's noise, `S` and `N` are diagonal, `phi` the features of a periodic kernel
//! ([`Periodic`]). Latents are `[e, B]`, the rows of `B` one after the other.

mod fit;

pub use fit::ResidualHyperparameters;

use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::periodic::{self, FEATURES};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, Periodic,
    ViewpointDerivative,
};

/// A model with such a process beside it, as an observation model.
pub struct ResidualProcess<'m> {
    model: &'m dyn ObservationModel,
    functions: Periodic,
    /// `R^-1 S`, `[M, M]`.
    loading: DMatrix<f64>,
    noise: MeasurementNoise,
}

impl<'m> ResidualProcess<'m> {
    /// Refuses a model whose whitening cannot be inverted, and deviations of another number or that are not positive.
    pub fn new(
        model: &'m dyn ObservationModel,
        fitted: &ResidualHyperparameters,
    ) -> Result<Self, AnswerError> {
        let m = model.measurement_dim();
        for deviations in [&fitted.signal, &fitted.noise] {
            if deviations.len() != m {
                let (got, expected) = (deviations.len(), m);
                return Err(AnswerError::Shape { what: "deviations of a residual process", got, expected });
            }
        }
        let whitening = model.noise().sqrt_information();
        let inverse = whitening.clone().try_inverse();
        let inverse = inverse.ok_or(AnswerError::NonFinite { what: "inverse of the model's whitening" })?;
        let precision = DVector::from_iterator(m, fitted.noise.iter().map(|deviation| deviation.recip()));
        Ok(Self {
            model,
            functions: Periodic::new(fitted.kappa),
            loading: inverse * DMatrix::from_diagonal(&DVector::from_column_slice(&fitted.signal)),
            noise: MeasurementNoise::new(
                DMatrix::from_diagonal(&precision) * whitening,
                fitted.degrees_of_freedom,
            )?,
        })
    }

    /// `e` and `B`, `[M, FEATURES]`.
    fn parts(&self, latent: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let d = self.model.latent_dim();
        let coefficients = latent.rows(d, latent.len() - d);
        (
            latent.rows(0, d).into_owned(),
            DMatrix::from_row_iterator(self.measurement_dim(), FEATURES, coefficients.iter().copied()),
        )
    }

    /// `R^-1 S B phi` for a row of features, which may be their derivative.
    fn correction(&self, coefficients: &DMatrix<f64>, phi: &[f64; FEATURES]) -> DVector<f64> {
        &self.loading * (coefficients * DVector::from_column_slice(phi))
    }
}

impl ObservationModel for ResidualProcess<'_> {
    fn latent_dim(&self) -> usize {
        self.model.latent_dim() + self.measurement_dim() * FEATURES
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.model.measure(crop)
    }

    /// What the model reads; of `B` a single view says nothing here.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let read = self.model.encode(crop, viewpoint)?;
        let rest = LatentGaussian::prior(self.latent_dim() - read.mean.len());
        let joined = |a: &DVector<f64>, b: &DVector<f64>| {
            DVector::from_iterator(a.len() + b.len(), a.iter().chain(b.iter()).copied())
        };
        Ok(LatentGaussian {
            mean: joined(&read.mean, &rest.mean),
            variance: joined(&read.variance, &rest.variance),
        })
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let (e, coefficients) = self.parts(latent);
        let phi = self.functions.features(viewpoint.azimuth());
        Ok(self.model.predict(&e, viewpoint)? + self.correction(&coefficients, &phi))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let (e, coefficients) = self.parts(latent);
        let of_model = self.model.linearize(&e, viewpoint)?;
        let phi = self.functions.features(viewpoint.azimuth());
        let (d, m) = (e.len(), self.measurement_dim());
        let mut d_latent = DMatrix::zeros(m, self.latent_dim());
        d_latent.columns_mut(0, d).copy_from(&of_model.d_latent);
        for (j, column) in self.loading.column_iter().enumerate() {
            for (i, x) in phi.iter().enumerate() {
                d_latent.set_column(d + j * FEATURES + i, &(column * *x));
            }
        }
        let by_azimuth = self.correction(&coefficients, &periodic::derivative(&phi));
        let mut by_coordinates = of_model.d_viewpoint.by_coordinates().clone();
        let upright = DMatrix::zeros(m, 0);
        by_coordinates +=
            ViewpointDerivative::by_azimuth_and_upright(viewpoint, &by_azimuth, &upright).by_coordinates();
        debug_assert_eq!(by_coordinates.ncols(), CONDITIONING);
        Ok(Linearization {
            mean: of_model.mean + self.correction(&coefficients, &phi),
            d_latent,
            d_viewpoint: ViewpointDerivative::new(by_coordinates),
        })
    }
}

#[cfg(test)]
mod tests;
