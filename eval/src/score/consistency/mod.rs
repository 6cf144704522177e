//! Consistency: whether errors are as large as the estimator's own covariances say.
//!
//! The normalized estimation error squared (NEES) of an error `e` of `n` numbers under its covariance `S` is `e^T S^-1 e` (Bar-Shalom, Li and
//! Kirubarajan 2001, 5.4.2). Of a consistent estimator it follows the chi-square law with `n` degrees of freedom, so that NEES / n is
//! 1 in the mean. Above 1 the estimator promises too much.

mod normalized_errors;
mod object;
mod pose;

pub use normalized_errors::NormalizedErrors;
pub use object::{ObjectGaussian, object_scores};
pub use pose::{PoseConsistency, pose_consistency, pose_scores};

use crate::result::metric::Metric;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use std::f64::consts::PI;

/// The name of the table of NEES and of negative log-likelihoods.
pub const CONSISTENCY: &str = "consistency";
/// Its columns.
pub const COLUMNS: [Metric; 16] = [
    Metric::NeesPositionEnd,
    Metric::NeesHeadingEnd,
    Metric::NeesPoseEnd,
    Metric::NeesPosition,
    Metric::NeesHeading,
    Metric::NeesPose,
    Metric::NeesObjectCenter,
    Metric::NeesObjectYaw,
    Metric::PositionSurpriseEnd,
    Metric::HeadingSurpriseEnd,
    Metric::PoseSurpriseEnd,
    Metric::PositionSurprise,
    Metric::HeadingSurprise,
    Metric::PoseSurprise,
    Metric::ObjectCenterSurprise,
    Metric::ObjectYawSurprise,
];

/// The name of the table of what lies inside the regions that should hold 50, 80 and 95%.
pub const COVERAGE: &str = "coverage";
/// Its columns.
pub const INSIDE: [Metric; 15] = [
    Metric::PositionInside50,
    Metric::PositionInside80,
    Metric::PositionInside95,
    Metric::HeadingInside50,
    Metric::HeadingInside80,
    Metric::HeadingInside95,
    Metric::PoseInside50,
    Metric::PoseInside80,
    Metric::PoseInside95,
    Metric::ObjectCenterInside50,
    Metric::ObjectCenterInside80,
    Metric::ObjectCenterInside95,
    Metric::ObjectYawInside50,
    Metric::ObjectYawInside80,
    Metric::ObjectYawInside95,
];

/// Numbers of a pose's error.
pub const POSE: usize = 6;

/// Below this share of its variance that its correlations leave to a number, a covariance is singular to rounding.
const SINGULAR: f64 = 1e-10;

/// An error against its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Normalized {
    /// NEES over the error's numbers.
    per_number: f64,
    /// `-log N(e; 0, S)`, nats.
    surprise: f64,
}

impl Normalized {
    /// `None` where the covariance is not finite and positive definite, or the error not finite.
    fn of<const N: usize>(error: &SVector<f64, N>, covariance: &SMatrix<f64, N, N>) -> Option<Self> {
        let deviations = covariance.diagonal().map(f64::sqrt);
        let correlations =
            SMatrix::<f64, N, N>::from_fn(|i, j| covariance[(i, j)] / (deviations[i] * deviations[j]));
        let root = correlations.cholesky()?.l();
        if root.diagonal().iter().any(|left| left * left <= SINGULAR) {
            return None;
        }
        let squared = root.solve_lower_triangular(&error.component_div(&deviations))?.norm_squared();
        let log_determinant: f64 = (0..N).map(|i| 2.0 * libm::log(root[(i, i)] * deviations[i])).sum();
        let surprise = (squared + log_determinant + N as f64 * libm::log(2.0 * PI)) / 2.0;
        surprise.is_finite().then_some(Self { per_number: squared / N as f64, surprise })
    }
}

/// The part of a rotation's error about an axis.
fn about(axis: &Vector3<f64>, omega: &Vector3<f64>, covariance: &Matrix3<f64>) -> Option<Normalized> {
    Normalized::of(&SVector::from([axis.dot(omega)]), &SMatrix::from([[variance_about(axis, covariance)]]))
}

fn variance_about(axis: &Vector3<f64>, covariance: &Matrix3<f64>) -> f64 {
    axis.dot(&(covariance * axis))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix6, SMatrix, SVector};
    use vantage_dataset::Seed;
    use vantage_dataset::seed::Stream;

    pub(super) fn draw<const N: usize>(
        covariance: &SMatrix<f64, N, N>,
        stream: &mut Stream,
    ) -> SVector<f64, N> {
        covariance.cholesky().unwrap().l() * SVector::<f64, N>::from_fn(|_, _| stream.normal())
    }

    /// Correlated, of a few hundredths of radians and metres.
    pub(super) fn covariance() -> Matrix6<f64> {
        let mut stream = Seed(1).stream("covariance", 0);
        let root = Matrix6::from_fn(|_, _| 0.02 * stream.normal());
        root * root.transpose() + Matrix6::identity() * 1e-4
    }
}
