//! Scores of an estimate after every step.

use super::ate::ate;
use super::consistency::pose_consistency;
use super::embedding::Scores;
use super::heading::heading_error;
use super::pairs::{Pairs, PairsError};
use crate::result::metric::Metric;
use nalgebra::Matrix6;
use vantage_dataset::Pose;

/// The name of the table.
pub const ONLINE: &str = "online";
/// Its columns.
pub const COLUMNS: [Metric; 6] = [
    Metric::NewestPosition,
    Metric::NewestHeading,
    Metric::NeesNewest,
    Metric::AteAtEnd,
    Metric::ApartAtEnd,
    Metric::ApartSettled,
];

/// What is known of an episode when it was driven, and after it.
#[derive(Clone, Copy, Debug)]
pub struct Driven<'a> {
    /// The newest pose after each step.
    pub newest: &'a [Pose],
    /// Covariances of their right perturbations.
    pub covariances: Option<&'a [Matrix6<f64>]>,
    /// All poses after the last step.
    pub at_end: &'a [Pose],
    /// All poses at the maximum, or as near to it as they came.
    pub settled: &'a [Pose],
    /// All poses by the whole episode at once.
    pub whole: &'a [Pose],
}

/// The scores; empty where no step was answered.
pub fn online_scores(truth: &[Pose], driven: &Driven<'_>) -> Result<Scores, PairsError> {
    let newest = Pairs::by_step(truth, driven.newest)?;
    let at_end = Pairs::by_step(truth, driven.at_end)?;
    let apart = Pairs::by_step(driven.whole, driven.at_end)?;
    let settled = Pairs::by_step(driven.whole, driven.settled)?;
    let consistency = driven.covariances.and_then(|covariances| pose_consistency(&newest, covariances));
    let nees = consistency.and_then(|found| found.pose.mean_nees());
    let values = [
        (Metric::NewestPosition, ate(&newest)),
        (Metric::NewestHeading, heading_error(&newest)),
        (Metric::NeesNewest, nees),
        (Metric::AteAtEnd, ate(&at_end)),
        (Metric::ApartAtEnd, ate(&apart)),
        (Metric::ApartSettled, ate(&settled)),
    ];
    Ok(values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect())
}

/// Distance of the newest position from the truth after each step, metres, once the first poses are laid on each other.
pub fn newest_errors(truth: &[Pose], newest: &[Pose]) -> Result<Vec<f64>, PairsError> {
    let pairs = Pairs::by_step(truth, newest)?;
    let apart = |(truth, newest): (Pose, Pose)| (truth.translation.vector - newest.translation.vector).norm();
    Ok(pairs.from_first().map(apart).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn newest_poses_are_scored_apart_from_what_became_of_them() {
        let path = |off: f64| -> Vec<Pose> {
            (0..3).map(|i| Pose::translation(f64::from(i), off * f64::from(i), 0.0)).collect()
        };
        let (truth, newest, at_end, whole) = (path(0.0), path(0.3), path(0.1), path(0.2));
        let covariances = vec![Matrix6::identity() * 0.01; 3];
        let driven = Driven {
            newest: &newest,
            covariances: Some(&covariances),
            at_end: &at_end,
            settled: &whole,
            whole: &whole,
        };
        let scores = online_scores(&truth, &driven).unwrap();
        let rms = |off: f64| off * (5.0f64 / 3.0).sqrt();
        assert_relative_eq!(scores[&Metric::NewestPosition], rms(0.3), epsilon = 1e-12);
        assert_relative_eq!(scores[&Metric::AteAtEnd], rms(0.1), epsilon = 1e-12);
        assert_relative_eq!(scores[&Metric::ApartAtEnd], rms(0.1), epsilon = 1e-12);
        assert_eq!(scores[&Metric::ApartSettled], 0.0);
        assert_relative_eq!(scores[&Metric::NeesNewest], (9.0 + 36.0) / 2.0 / 6.0, epsilon = 1e-9);
        assert_eq!(newest_errors(&truth, &newest).unwrap(), [0.0, 0.3, 0.6]);
        assert!(newest_errors(&truth, &newest[..2]).is_err());
    }
}
