//! An untrained Gaussian process per object over the azimuth: a baseline that knows nothing of objects but their own views.
//!
//! ```text
//! m_j(z) = f_j(azimuth) + eps_j,   f_j ~ GP(0, s_j^2 k),   k(a, a') = exp(kappa (cos(a - a') - 1))
//!        = s_j phi(azimuth)^T b_j + eps_j,   b_j ~ N(0, I),   k(a, a') = phi(a)^T phi(a')
//! ```
//!
//! The kernel's spectrum ends at [`HARMONICS`](vantage_model::periodic::HARMONICS), so that the coefficients `b` of all components are the latent `e` of Eq. 10, and its
//! prior is the standard normal one. The prior does not change as the object turns: the object's frame is free.

mod fit;
mod hyperparameters;
mod reduced;

pub use hyperparameters::Hyperparameters;
pub use reduced::COMPONENTS;

use nalgebra::{DMatrix, DVector};
use std::sync::LazyLock;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::periodic::{self, FEATURES};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, Periodic,
    ViewpointDerivative,
};

/// The process as an observation model of [`COMPONENTS`] measured and `COMPONENTS * FEATURES` latent numbers.
#[derive(Debug)]
pub struct GaussianProcess {
    hyperparameters: Hyperparameters,
    functions: Periodic,
    noise: MeasurementNoise,
}

impl GaussianProcess {
    /// Of these hyper-parameters; refuses deviations that are not positive.
    pub fn new(hyperparameters: Hyperparameters) -> Result<Self, AnswerError> {
        let precision = DVector::from_iterator(COMPONENTS, hyperparameters.noise.iter().map(|s| s.recip()));
        let noise =
            MeasurementNoise::new(DMatrix::from_diagonal(&precision), hyperparameters.degrees_of_freedom)?;
        Ok(Self { hyperparameters, functions: Periodic::new(hyperparameters.kappa), noise })
    }

    /// That of [`Hyperparameters::FITTED`].
    pub fn fitted() -> &'static Self {
        static FITTED: LazyLock<GaussianProcess> = LazyLock::new(|| {
            GaussianProcess::new(Hyperparameters::FITTED).expect("the deviations are positive")
        });
        &FITTED
    }

    /// `h(e, x_rel)` for a row of features, which may be their derivative.
    fn applied(&self, latent: &DVector<f64>, features: &[f64; FEATURES]) -> DVector<f64> {
        let signal = self.hyperparameters.signal;
        DVector::from_fn(COMPONENTS, |j, _| {
            let coefficients = latent.iter().skip(j * FEATURES);
            signal[j] * coefficients.zip(features).map(|(b, phi)| b * phi).sum::<f64>()
        })
    }

    fn features(&self, viewpoint: &Viewpoint) -> [f64; FEATURES] {
        self.functions.features(viewpoint.azimuth())
    }
}

impl ObservationModel for GaussianProcess {
    fn latent_dim(&self) -> usize {
        COMPONENTS * FEATURES
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        reduced::measurement(crop).ok_or(AnswerError::NonFinite { what: "measurement of a black crop" })
    }

    /// Mean and marginal variances of the coefficients after this view alone.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let (measured, phi) = (self.measure(crop)?, self.features(viewpoint));
        let Hyperparameters { signal, noise, .. } = &self.hyperparameters;
        let known: f64 = phi.iter().map(|x| x * x).sum();
        let mut posterior = LatentGaussian::prior(self.latent_dim());
        for j in 0..COMPONENTS {
            let evidence = known + (noise[j] / signal[j]).powi(2);
            for (i, x) in phi.iter().enumerate() {
                posterior.mean[j * FEATURES + i] = x * measured[j] / signal[j] / evidence;
                posterior.variance[j * FEATURES + i] = 1.0 - x * x / evidence;
            }
        }
        Ok(posterior)
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(self.applied(latent, &self.features(viewpoint)))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let phi = self.features(viewpoint);
        let mut d_latent = DMatrix::zeros(COMPONENTS, self.latent_dim());
        for (j, signal) in self.hyperparameters.signal.iter().enumerate() {
            for (i, x) in phi.iter().enumerate() {
                d_latent[(j, j * FEATURES + i)] = signal * x;
            }
        }
        let by_azimuth = self.applied(latent, &periodic::derivative(&phi));
        let mut by_coordinates = DMatrix::zeros(COMPONENTS, CONDITIONING);
        let (sin, cos) = libm::sincos(viewpoint.azimuth());
        // d azimuth = cos d(sin) - sin d(cos), the first two coordinates.
        by_coordinates.set_column(0, &(&by_azimuth * -sin));
        by_coordinates.set_column(1, &(&by_azimuth * cos));
        let d_viewpoint = ViewpointDerivative::new(by_coordinates);
        Ok(Linearization { mean: self.applied(latent, &phi), d_latent, d_viewpoint })
    }
}

#[cfg(test)]
mod tests;
