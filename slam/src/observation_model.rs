//! The learned model the estimator runs: `p(z | e, x_rel)` and `q(e | z, x_rel)` of III-A, in the reduced
//! measurement of IV-C.

use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};

/// A viewpoint-dependent observation model, M measured numbers and D latent ones.
pub trait ObservationModel: Send + Sync {
    /// D, the length of a latent `e`.
    fn latent_dim(&self) -> usize;

    /// M, the length of a reduced measurement `m(z)`.
    fn measurement_dim(&self) -> usize;

    /// `m(z)`, `[M]`: the reduced measurement of a crop.
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError>;

    /// `q(e | z, x_rel)`: the latent's posterior after one view, `[D]`.
    ///
    /// The orientation search asks for one crop under every yaw of its grid: what depends on the crop alone is
    /// worth keeping between calls.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError>;

    /// `h(e, x_rel)`, `[M]`: the measurement expected of latent `e` (`[D]`) under a viewpoint's conditioning
    /// numbers.
    fn predict(
        &self,
        latent: &DVector<f64>,
        conditioning: &[f64; CONDITIONING],
    ) -> Result<DVector<f64>, ModelError>;

    /// [`ObservationModel::predict`] with its exact derivatives.
    fn linearize(
        &self,
        latent: &DVector<f64>,
        conditioning: &[f64; CONDITIONING],
    ) -> Result<Linearization, ModelError>;

    /// The distribution of `m(z) - h(e, x_rel)`.
    fn noise(&self) -> &MeasurementNoise;
}

/// A Gaussian over a latent with diagonal covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct LatentGaussian {
    /// Mean, `[D]`.
    pub mean: DVector<f64>,
    /// Variances, `[D]`.
    pub variance: DVector<f64>,
}

impl LatentGaussian {
    /// The prior P(e) = N(0, I).
    pub fn prior(dim: usize) -> Self {
        Self { mean: DVector::zeros(dim), variance: DVector::from_element(dim, 1.0) }
    }

    /// The product of the prior N(0, I) with the posteriors of several views, normalised.
    pub fn product<'a>(dim: usize, views: impl IntoIterator<Item = &'a LatentGaussian>) -> Self {
        let mut information = DVector::from_element(dim, 1.0);
        let mut weighted = DVector::zeros(dim);
        for view in views {
            let precision = view.variance.map(|v| 1.0 / v);
            weighted += precision.component_mul(&view.mean);
            information += precision;
        }
        let variance = information.map(|i| 1.0 / i);
        Self { mean: variance.component_mul(&weighted), variance }
    }

    /// Whether it is a Gaussian over `dim` numbers: finite means, finite positive variances.
    pub fn is_valid(&self, dim: usize) -> bool {
        self.mean.len() == dim
            && self.variance.len() == dim
            && self.mean.iter().all(|m| m.is_finite())
            && self.variance.iter().all(|v| v.is_finite() && *v > 0.0)
    }
}

/// The model's prediction near a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// `h(e, x_rel)`, `[M]`.
    pub mean: DVector<f64>,
    /// `d h / d e`, `[M x D]`.
    pub d_latent: DMatrix<f64>,
    /// `d h / d conditioning`, `[M x CONDITIONING]`.
    pub d_conditioning: DMatrix<f64>,
}

impl Linearization {
    /// Whether it has the shapes of `M` measured and `D` latent numbers and is finite throughout.
    pub fn is_valid(&self, measurement_dim: usize, latent_dim: usize) -> bool {
        self.mean.len() == measurement_dim
            && self.d_latent.shape() == (measurement_dim, latent_dim)
            && self.d_conditioning.shape() == (measurement_dim, CONDITIONING)
            && self.mean.iter().chain(&self.d_latent).chain(&self.d_conditioning).all(|x| x.is_finite())
    }
}

/// A multivariate Student-t over the residual `r = m(z) - h(e, x_rel)`, of density proportional to
/// `(1 + |W r / scale|^2 / nu)^(-(nu + M)/2)`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementNoise {
    sqrt_information: DMatrix<f64>,
    degrees_of_freedom: f64,
    scale: f64,
}

impl MeasurementNoise {
    /// Noise with whitening matrix `W` (`[M x M]`), `nu` degrees of freedom (infinity for a Gaussian) and a
    /// scale that multiplies the residual's spread.
    pub fn new(
        sqrt_information: DMatrix<f64>,
        degrees_of_freedom: f64,
        scale: f64,
    ) -> Result<Self, ModelError> {
        let (rows, columns) = sqrt_information.shape();
        if rows != columns {
            return Err(ModelError::Shape {
                what: "square root of the information (columns)",
                got: columns,
                expected: rows,
            });
        }
        let valid = sqrt_information.iter().all(|x| x.is_finite())
            && degrees_of_freedom > 0.0
            && scale > 0.0
            && scale.is_finite();
        if valid {
            Ok(Self { sqrt_information, degrees_of_freedom, scale })
        } else {
            Err(ModelError::NonFinite { what: "measurement noise" })
        }
    }

    /// `W`, `[M x M]`.
    pub fn sqrt_information(&self) -> &DMatrix<f64> {
        &self.sqrt_information
    }

    /// `nu`.
    pub fn degrees_of_freedom(&self) -> f64 {
        self.degrees_of_freedom
    }

    /// The scale.
    pub fn scale(&self) -> f64 {
        self.scale
    }
}

/// Why a model gave no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The network's output is not a finite number. The detection is dropped and counted.
    #[error(
        "{what}: got a number that is not finite or not positive where it must be; check the model's weights"
    )]
    NonFinite {
        /// Which output.
        what: &'static str,
    },
    /// An output or input has the wrong length.
    #[error("{what}: got {got} numbers, expected {expected}; the model does not fit its manifest")]
    Shape {
        /// Which one.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length it should have.
        expected: usize,
    },
    /// The inference runtime failed.
    #[error("inference failed: {message}")]
    Runtime {
        /// The runtime's message.
        message: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn product_of_views_adds_information() {
        let view = LatentGaussian {
            mean: DVector::from_vec(vec![2.0, -1.0]),
            variance: DVector::from_vec(vec![0.5, 1.0]),
        };
        let product = LatentGaussian::product(2, [&view, &view]);
        assert_relative_eq!(product.variance, DVector::from_vec(vec![0.2, 1.0 / 3.0]), epsilon = 1e-12);
        assert_relative_eq!(product.mean, DVector::from_vec(vec![1.6, -2.0 / 3.0]), epsilon = 1e-12);
        assert_eq!(LatentGaussian::product(3, []), LatentGaussian::prior(3));
    }

    #[test]
    fn noise_refuses_what_is_no_distribution() {
        let identity = DMatrix::identity(2, 2);
        assert!(MeasurementNoise::new(identity.clone(), f64::INFINITY, 1.0).is_ok());
        for (nu, scale) in [(0.0, 1.0), (f64::NAN, 1.0), (4.0, 0.0), (4.0, f64::NAN), (4.0, f64::INFINITY)] {
            assert!(MeasurementNoise::new(identity.clone(), nu, scale).is_err(), "nu {nu}, scale {scale}");
        }
        assert!(MeasurementNoise::new(DMatrix::zeros(2, 3), 4.0, 1.0).is_err());
        assert!(MeasurementNoise::new(identity * f64::NAN, 4.0, 1.0).is_err());
    }
}
