//! Noise models: whitening by a square root of the information, and robust kernels.
//!
//! A factor costs `rho(s)` with `s = |W r|^2` and `W^T W` the information. A kernel is solved by iteratively
//! reweighted least squares with weight `2 rho'(s)`:
//!
//! | kernel | rho(s) | weight |
//! |---|---|---|
//! | Gaussian | s/2 | 1 |
//! | Huber, threshold k | s/2 where sqrt(s) <= k, else k sqrt(s) - k^2/2 | min(1, k / sqrt(s)) |
//! | multivariate Student-t, nu degrees of freedom, M residuals | (nu + M)/2 log(1 + s/nu) | (nu + M)/(nu + s) |

use garde::Validate;
use nalgebra::Matrix6;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;
use vantage_model::student_t;

/// A robust kernel on the squared norm of a whole whitened residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Kernel {
    /// Least squares: no robustness.
    Gaussian,
    /// Quadratic near zero, linear beyond the threshold.
    Huber {
        /// Norm of the whitened residual, in sigmas, beyond which the cost grows linearly.
        #[garde(range(min = 1e-3, max = 1e6), custom(not_nan))]
        threshold: f64,
    },
    /// The negative log-likelihood of a multivariate Student-t.
    StudentT {
        /// `nu`; the smaller, the heavier the tails.
        #[garde(range(min = 1e-3, max = 1e9), custom(not_nan))]
        degrees_of_freedom: f64,
    },
}

impl Kernel {
    /// The Student t of `nu` degrees of freedom, Gaussian where they are infinite.
    pub fn of_degrees_of_freedom(nu: f64) -> Self {
        if nu.is_finite() { Kernel::StudentT { degrees_of_freedom: nu } } else { Kernel::Gaussian }
    }

    /// `rho(s)` of a residual of `dim` numbers, in nats up to a constant.
    pub fn loss(&self, s: f64, dim: usize) -> f64 {
        match *self {
            Kernel::Gaussian => s / 2.0,
            Kernel::Huber { threshold } if s > threshold * threshold => {
                threshold * s.sqrt() - threshold * threshold / 2.0
            }
            Kernel::Huber { .. } => s / 2.0,
            Kernel::StudentT { degrees_of_freedom } => student_t::loss(s, dim, degrees_of_freedom),
        }
    }

    /// `2 rho'(s)`.
    pub fn weight(&self, s: f64, dim: usize) -> f64 {
        match *self {
            Kernel::Gaussian => 1.0,
            Kernel::Huber { threshold } if s > threshold * threshold => threshold / s.sqrt(),
            Kernel::Huber { .. } => 1.0,
            Kernel::StudentT { degrees_of_freedom } => student_t::weight(s, dim, degrees_of_freedom),
        }
    }
}

/// `W` with `W^T W = covariance^-1`, or `None` where the covariance is not finite and positive definite.
pub fn sqrt_information(covariance: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    let symmetric = (covariance - covariance.transpose()).amax() <= 1e-9 * covariance.amax();
    let l = covariance.cholesky().filter(|_| symmetric)?.l();
    let w = l.solve_lower_triangular(&Matrix6::identity())?;
    w.iter().all(|x| x.is_finite()).then_some(w)
}

/// Noise of a box centre as a bearing to the object's centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct BearingNoise {
    /// Part of the standard deviation that does not depend on the box: tangent of the angle, as
    /// pixels over the focal length.
    #[garde(range(min = 1e-6, max = 1.0), custom(not_nan))]
    pub fixed: f64,
    /// Part of the standard deviation per angular size of the box (its longer side over the focal length).
    #[garde(range(min = 0.0, max = 10.0), custom(not_nan))]
    pub proportional: f64,
}

impl BearingNoise {
    /// Standard deviation of either image coordinate over the focal length, for a box of `angular_size`
    /// (side over focal length).
    pub fn sigma(&self, angular_size: f64) -> f64 {
        libm::hypot(self.fixed, self.proportional * angular_size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const KERNELS: [Kernel; 5] = [
        Kernel::Gaussian,
        Kernel::Huber { threshold: 1.345 },
        Kernel::StudentT { degrees_of_freedom: 1.0 },
        Kernel::StudentT { degrees_of_freedom: 4.0 },
        Kernel::StudentT { degrees_of_freedom: 1e6 },
    ];

    #[test]
    fn weight_is_twice_the_derivative_of_the_loss() {
        for kernel in KERNELS {
            for s in [1e-3, 0.5, 1.7, 2.0, 40.0, 1e4] {
                for dim in [1, 2, 32] {
                    let h = 1e-5 * s;
                    let slope = (kernel.loss(s + h, dim) - kernel.loss(s - h, dim)) / (2.0 * h);
                    assert_relative_eq!(kernel.weight(s, dim), 2.0 * slope, max_relative = 1e-6);
                }
            }
        }
    }

    #[test]
    fn loss_starts_at_zero_and_never_falls() {
        for kernel in KERNELS {
            assert_relative_eq!(kernel.loss(0.0, 3), 0.0);
            let losses: Vec<f64> = (0..100).map(|i| kernel.loss(f64::from(i) * 0.37, 3)).collect();
            assert!(losses.windows(2).all(|w| w[0] < w[1]), "{kernel:?}: {losses:?}");
        }
    }

    #[test]
    fn sqrt_information_inverts_and_refuses_what_is_not_a_covariance() {
        let a = Matrix6::from_fn(|i, j| ((i * 7 + j * 3) % 5) as f64 * 0.3) + Matrix6::identity();
        let covariance = a * a.transpose();
        let w = sqrt_information(&covariance).unwrap();
        assert_relative_eq!(w.transpose() * w * covariance, Matrix6::identity(), epsilon = 1e-9);
        assert!(sqrt_information(&Matrix6::zeros()).is_none());
        assert!(sqrt_information(&-Matrix6::identity()).is_none());
        assert!(sqrt_information(&Matrix6::from_element(f64::NAN)).is_none());
        let mut skewed = Matrix6::identity();
        skewed[(0, 1)] = 0.5;
        assert!(sqrt_information(&skewed).is_none());
    }
}
