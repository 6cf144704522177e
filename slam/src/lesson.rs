//! What drives teach of the model, carried from one drive to the next. Its size is bounded.
//!
//! Worlds change, so that what was learnt counts [`KEPT`] as much with every later drive: odds and views of the drives so far are weighed
//! down when another drive is added. What is learnt of the domain becomes the prior of the next drive's, an autoregression whose stationary
//! distribution is the prior of a first drive:
//!
//! ```text
//! u' = a u + sqrt(1 - a^2) w,   w ~ N(0, I),   a = KEPT
//! ```
//!
//! Where it is not certain who is who, each way to tell it teaches a lesson of its own, and these are [mixed](Lesson::mixed).

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// `a`: how much of what is known counts when another drive is added.
pub const KEPT: f64 = 0.9;
/// Spreads of the semantic residual that are tried on a drive.
pub(crate) const SPREADS: usize = 4;
/// Deviations of the discrepancy that are tried on a drive.
pub(crate) const DISCREPANCIES: usize = 3;
/// Processes per object that are tried on a drive.
pub const PROCESSES: usize = 3;

/// What the drives so far taught; of none, that of a first drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lesson {
    /// Of how far crops are to be trusted.
    pub noise: NoiseOdds,
    /// Of a process per object that corrects the model.
    pub process: ProcessOdds,
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

/// Likewise, of processes per object, over the model alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessOdds {
    /// Of the model alone, and of each size of a process beside it.
    pub size: [f64; PROCESSES + 1],
    /// Of the noise, under the size that was taken on its drive.
    pub noise: NoiseOdds,
}

impl Lesson {
    /// What a drive taught by several ways to tell who is who, with the weight of each; they add up to 1. At least one.
    ///
    /// Log-evidences of the noise are averaged. Of the domain it is the Gaussian of the mixture's mean and covariance. Of the layer it is the
    /// mean regression, with the mean of the changes that each made. A way that knows nothing of a part counts as a first drive.
    pub fn mixed(ways: &[(f64, Self)]) -> Self {
        let odds = |of: fn(&Self) -> &[f64]| {
            move |i: usize| ways.iter().map(|(weight, way)| weight * of(way)[i]).sum()
        };
        let noise = NoiseOdds {
            spread: std::array::from_fn(odds(|of| &of.noise.spread)),
            discrepancy: std::array::from_fn(odds(|of| &of.noise.discrepancy)),
        };
        let process = ProcessOdds {
            size: std::array::from_fn(odds(|of| &of.process.size)),
            noise: NoiseOdds {
                spread: std::array::from_fn(odds(|of| &of.process.noise.spread)),
                discrepancy: std::array::from_fn(odds(|of| &of.process.noise.discrepancy)),
            },
        };
        let domains: Vec<_> = ways.iter().map(|(weight, way)| (*weight, way.domain.as_ref())).collect();
        let decoders: Vec<_> = ways.iter().map(|(weight, way)| (*weight, way.decoder.as_ref())).collect();
        Self { noise, process, domain: DomainBelief::mixed(&domains), decoder: LayerLesson::mixed(&decoders) }
    }
}

/// Log-evidences with those of another drive.
fn sum<const N: usize>(before: &[f64; N], drive: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| KEPT * before[i] + drive[i])
}

impl NoiseOdds {
    /// With those of another drive, after which what was there before counts less.
    pub(crate) fn after(&self, drive: &Self) -> Self {
        Self {
            spread: sum(&self.spread, &drive.spread),
            discrepancy: sum(&self.discrepancy, &drive.discrepancy),
        }
    }
}

impl ProcessOdds {
    /// Likewise.
    pub(crate) fn after(&self, drive: &Self) -> Self {
        Self { size: sum(&self.size, &drive.size), noise: self.noise.after(&drive.noise) }
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
    /// The mean and the covariance of a mixture; `None` where nothing is known by any way.
    fn mixed(ways: &[(f64, Option<&Self>)]) -> Option<Self> {
        let dim = ways.iter().find_map(|(_, of)| *of)?.mean.len();
        let first = Self { mean: DVector::zeros(dim), covariance: DMatrix::identity(dim, dim) };
        let ways = || ways.iter().map(|(weight, of)| (*weight, of.unwrap_or(&first)));
        let mean = ways().fold(DVector::zeros(dim), |sum, (weight, of)| sum + &of.mean * weight);
        let spread = |(weight, of): (f64, &Self)| {
            let off = &of.mean - &mean;
            (&of.covariance + &off * off.transpose()) * weight
        };
        let covariance = ways().map(spread).fold(DMatrix::zeros(dim, dim), |sum, of| sum + of);
        Some(Self { mean, covariance })
    }

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

impl LayerLesson {
    /// The mean; `None` where nothing is known by any way.
    fn mixed(ways: &[(f64, Option<&Self>)]) -> Option<Self> {
        let mean = |part: fn(&Self) -> &DMatrix<f64>| {
            let weighed = ways.iter().filter_map(|(weight, of)| Some(part((*of)?) * *weight));
            weighed.reduce(|sum, next| sum + next)
        };
        Some(Self {
            information: mean(|way| &way.information)?,
            moment: mean(|way| &way.moment)?,
            change: mean(|way| &way.change)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn lesson(spread: f64, mean: f64, change: f64) -> Lesson {
        Lesson {
            noise: NoiseOdds { spread: [0.0, spread, 0.0, 0.0], discrepancy: [0.0, -spread, 0.0] },
            process: ProcessOdds {
                size: [0.0, 0.0, spread, 0.0],
                noise: NoiseOdds { spread: [0.0, 0.0, 0.0, -spread], ..NoiseOdds::default() },
            },
            domain: Some(DomainBelief {
                mean: DVector::repeat(1, mean),
                covariance: DMatrix::identity(1, 1),
            }),
            decoder: Some(LayerLesson {
                information: DMatrix::repeat(1, 1, 4.0),
                moment: DMatrix::repeat(1, 1, 4.0 * change),
                change: DMatrix::repeat(1, 1, change),
            }),
        }
    }

    #[test]
    fn ways_to_tell_who_is_who_are_mixed_by_their_weights() {
        let mixed = Lesson::mixed(&[(0.75, lesson(-20.0, 1.0, 2.0)), (0.25, lesson(4.0, 5.0, -2.0))]);
        assert_eq!((mixed.noise.spread, mixed.noise.discrepancy), ([0.0, -14.0, 0.0, 0.0], [0.0, 14.0, 0.0]));
        let of_process = (mixed.process.size, mixed.process.noise.spread);
        assert_eq!(of_process, ([0.0, 0.0, -14.0, 0.0], [0.0, 0.0, 0.0, 14.0]));
        let domain = mixed.domain.unwrap();
        // Of means 1 and 5: 2, with 0.75 * 1 + 0.25 * 9 between them.
        assert_relative_eq!(domain.mean[0], 2.0, epsilon = 1e-12);
        assert_relative_eq!(domain.covariance[(0, 0)], 1.0 + 3.0, epsilon = 1e-12);
        let decoder = mixed.decoder.unwrap();
        assert_relative_eq!(decoder.change[(0, 0)], 1.0, epsilon = 1e-12);
        assert_relative_eq!(decoder.moment[(0, 0)] / decoder.information[(0, 0)], 1.0, epsilon = 1e-12);
    }

    #[test]
    fn of_one_way_it_is_the_lesson_and_a_way_that_taught_nothing_is_a_first_drive() {
        let taught = lesson(1.0, 4.0, 2.0);
        assert_eq!(Lesson::mixed(&[(1.0, taught.clone())]), taught);
        assert_eq!(Lesson::mixed(&[(0.4, Lesson::default()), (0.6, Lesson::default())]), Lesson::default());
        let mixed = Lesson::mixed(&[(0.5, taught), (0.5, Lesson::default())]);
        assert_eq!(mixed.noise.spread[1], 0.5);
        let domain = mixed.domain.unwrap();
        assert_relative_eq!(domain.mean[0], 2.0, epsilon = 1e-12);
        assert_relative_eq!(domain.covariance[(0, 0)], 5.0, epsilon = 1e-12);
        let decoder = mixed.decoder.unwrap();
        assert_relative_eq!(decoder.information[(0, 0)], 2.0, epsilon = 1e-12);
        assert_relative_eq!(decoder.change[(0, 0)], 1.0, epsilon = 1e-12);
    }

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
