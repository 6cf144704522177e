//! The noise of the reduced measurement.

use crate::{AnswerError, student_t};
use nalgebra::DMatrix;

/// A multivariate Student-t over the residual `r = m(z) - h(e, x_rel)`, of density proportional to
/// `(1 + |W r|^2 / nu)^(-(nu + M)/2)`: see [`student_t`](crate::student_t).
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementNoise {
    sqrt_information: DMatrix<f64>,
    degrees_of_freedom: f64,
}

impl MeasurementNoise {
    /// Noise with whitening matrix `W` (`[M x M]`) and `nu` degrees of freedom, infinity for a Gaussian.
    pub fn new(sqrt_information: DMatrix<f64>, degrees_of_freedom: f64) -> Result<Self, AnswerError> {
        let (rows, columns) = sqrt_information.shape();
        if rows != columns {
            return Err(AnswerError::Shape {
                what: "square root of the information (columns)",
                got: columns,
                expected: rows,
            });
        }
        if sqrt_information.iter().all(|x| x.is_finite()) && degrees_of_freedom > 0.0 {
            Ok(Self { sqrt_information, degrees_of_freedom })
        } else {
            Err(AnswerError::NonFinite { what: "measurement noise" })
        }
    }

    /// M.
    pub fn dimension(&self) -> usize {
        self.sqrt_information.nrows()
    }

    /// `W`, `[M x M]`.
    pub fn sqrt_information(&self) -> &DMatrix<f64> {
        &self.sqrt_information
    }

    /// `nu`.
    pub fn degrees_of_freedom(&self) -> f64 {
        self.degrees_of_freedom
    }

    /// `log p(r = 0)`, nats: what a likelihood needs to be comparable between noises. Minus infinity where `W` is singular.
    pub fn log_normalizer(&self) -> f64 {
        let log_det = libm::log(self.sqrt_information.determinant().abs());
        student_t::log_normalizer(self.dimension(), self.degrees_of_freedom) + log_det
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_distribution_is_refused() {
        let identity = DMatrix::identity(2, 2);
        assert_eq!(MeasurementNoise::new(identity.clone(), f64::INFINITY).unwrap().dimension(), 2);
        for nu in [0.0, -1.0, f64::NAN] {
            assert!(MeasurementNoise::new(identity.clone(), nu).is_err(), "nu {nu}");
        }
        assert!(MeasurementNoise::new(DMatrix::zeros(2, 3), 4.0).is_err());
        assert!(MeasurementNoise::new(identity * f64::NAN, 4.0).is_err());
    }

    #[test]
    fn densities_integrate_to_one_whatever_the_scale_and_the_tails() {
        for (scale, nu) in [(0.5, 3.0), (2.0, 12.0), (2.0, f64::INFINITY)] {
            let noise = MeasurementNoise::new(DMatrix::identity(1, 1) * scale, nu).unwrap();
            let step = 0.01;
            let density = |i: i32| {
                let s = (scale * step * f64::from(i)).powi(2);
                let loss = if nu.is_finite() { student_t::loss(s, 1, nu) } else { s / 2.0 };
                (noise.log_normalizer() - loss).exp()
            };
            let integral: f64 = (-100_000..=100_000).map(|i| density(i) * step).sum();
            assert!((integral - 1.0).abs() < 1e-5, "{scale}, {nu}: {integral}");
        }
    }
}
