//! What drives teach of the model, carried from one drive to the next. Its size is bounded.
//!
//! Worlds change, so that what was learnt counts [`KEPT`] as much with every later drive: odds and views of the drives so far are weighed
//! down when another drive is added. What is learnt of the domain becomes the prior of the next drive's, an autoregression whose stationary
//! distribution is the prior of a first drive:
//!
//! ```text
//! u' = a u + sqrt(1 - a^2) w,   w ~ N(0, I),   a = KEPT
//! ```

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// `a`: how much of what is known counts when another drive is added.
pub const KEPT: f64 = 0.9;
/// Spreads of the semantic residual that are tried on a drive.
pub(crate) const SPREADS: usize = 4;
/// Deviations of the discrepancy that are tried on a drive.
pub(crate) const DISCREPANCIES: usize = 3;

/// What the drives so far taught; of none, that of a first drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lesson {
    /// Of how far crops are to be trusted.
    pub noise: NoiseOdds,
    /// Of what this world's crops have otherwise than those of training.
    pub domain: Option<DomainBelief>,
    /// Of the decoder's last layer.
    pub decoder: Option<LayerLesson>,
}

/// Log-evidences of drives, nats, over those of what was told.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseOdds {
    /// Of each spread of the semantic residual.
    pub spread: [f64; SPREADS],
    /// Of each deviation of the discrepancy.
    pub discrepancy: [f64; DISCREPANCIES],
}

impl NoiseOdds {
    /// With those of another drive, after which what was there before counts less.
    pub(crate) fn after(&self, drive: &Self) -> Self {
        fn sum<const N: usize>(before: &[f64; N], drive: &[f64; N]) -> [f64; N] {
            std::array::from_fn(|i| KEPT * before[i] + drive[i])
        }
        Self {
            spread: sum(&self.spread, &drive.spread),
            discrepancy: sum(&self.discrepancy, &drive.discrepancy),
        }
    }
}

/// A Gaussian over the numbers `u` of a [`Domain`](crate::domain::Domain).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DomainBelief {
    /// `[dim]`.
    pub mean: DVector<f64>,
    /// `[dim x dim]`.
    pub covariance: DMatrix<f64>,
}

impl DomainBelief {
    /// That of the next drive.
    pub(crate) fn of_next_drive(&self) -> Self {
        let Self { mean, covariance } = self;
        let fresh = DMatrix::identity(mean.len(), mean.len()) * (1.0 - KEPT * KEPT);
        Self { mean: mean * KEPT, covariance: covariance * (KEPT * KEPT) + fresh }
    }
}

/// Views seen, as a regression of residuals on a layer's features, and the change of the layer that they made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerLesson {
    /// `sum w phi phi^T`, `[F x F]`.
    pub information: DMatrix<f64>,
    /// `sum w (m(z) - W phi) phi^T`, `[M x F]`, of the layer `W` that training left.
    pub moment: DMatrix<f64>,
    /// Of `W`, `[M x F]`.
    pub change: DMatrix<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_domain_that_nothing_is_learnt_of_becomes_that_of_a_first_drive() {
        let mut belief =
            DomainBelief { mean: DVector::repeat(2, 3.0), covariance: DMatrix::identity(2, 2) * 0.1 };
        for _ in 0..200 {
            belief = belief.of_next_drive();
        }
        assert_relative_eq!(belief.mean, DVector::zeros(2), epsilon = 1e-6);
        assert_relative_eq!(belief.covariance, DMatrix::identity(2, 2), epsilon = 1e-6);
    }

    #[test]
    fn odds_of_drives_add_up_and_older_ones_count_less() {
        let drive = NoiseOdds { spread: [0.0, 1.0, 2.0, -1.0], discrepancy: [0.0, 0.5, -0.5] };
        let twice = NoiseOdds::default().after(&drive).after(&drive);
        assert_eq!(twice.spread, [0.0, 1.9, 3.8, -1.9]);
        assert_eq!(twice.discrepancy, [0.0, 0.95, -0.95]);
    }
}
