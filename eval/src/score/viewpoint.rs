//! Viewpoint error: how far the azimuth that a model finds most likely is from the true one.
//!
//! A model that is to help SLAM has to prefer the true viewpoint on instances it has never seen; this measures it
//! before it enters a graph.

use crate::result::statistics::quantile;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use vantage_dataset::Symmetry;

/// Spacing of the search grid, radians.
const GRID_STEP: f64 = 5.0 * PI / 180.0;
/// Halvings of the step around the best grid point: down to 0.08 degrees.
const REFINEMENTS: u32 = 6;
/// Errors below this angle count as right, radians.
pub const RIGHT_WITHIN: f64 = 15.0 * PI / 180.0;

/// The most likely azimuth, radians in `[-pi, pi)`: a grid of 5 degrees, refined around its best point.
///
/// `None` where the likelihood is not finite somewhere, or prefers no azimuth at all.
pub fn most_likely_azimuth(mut log_likelihood: impl FnMut(f64) -> f64) -> Option<f64> {
    let points = (2.0 * PI / GRID_STEP).round() as usize;
    let mut best = (f64::NEG_INFINITY, 0.0);
    let mut worst = f64::INFINITY;
    for i in 0..points {
        let azimuth = -PI + 2.0 * PI * i as f64 / points as f64;
        let value = log_likelihood(azimuth);
        if !value.is_finite() {
            return None;
        }
        worst = worst.min(value);
        if value > best.0 {
            best = (value, azimuth);
        }
    }
    if best.0 <= worst {
        return None;
    }
    let mut step = GRID_STEP;
    for _ in 0..REFINEMENTS {
        step /= 2.0;
        for azimuth in [best.1 - step, best.1 + step] {
            let value = log_likelihood(azimuth);
            if !value.is_finite() {
                return None;
            }
            if value > best.0 {
                best = (value, azimuth);
            }
        }
    }
    Some((best.1 + PI).rem_euclid(2.0 * PI) - PI)
}

/// What the model said of one crop of an unseen instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewpointTrial {
    /// The instance's family.
    pub family: String,
    /// Its symmetry about z.
    pub symmetry: Symmetry,
    /// The true azimuth, radians.
    pub azimuth: f64,
    /// The most likely azimuth, radians; `None` where the model preferred none.
    pub found: Option<f64>,
}

impl ViewpointTrial {
    /// The error modulo the symmetry, radians. No answer is as wrong as an answer can be. `None` for a surface of
    /// revolution, which has no azimuth to find.
    pub fn error(&self) -> Option<f64> {
        let largest = largest_error(self.symmetry)?;
        match self.found {
            Some(found) => self.symmetry.azimuth_distance(self.azimuth, found),
            None => Some(largest),
        }
    }
}

/// Viewpoint errors of a set of trials, radians, beside those of a guess at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewpointSummary {
    /// Trials with an azimuth to find: the denominator.
    pub trials: usize,
    /// Of those, how many the model had no answer to.
    pub unanswered: usize,
    /// Errors of the model; `None` for no trial.
    pub model: Option<ErrorShape>,
    /// Errors to be expected of an azimuth drawn uniformly.
    pub chance: Option<ErrorShape>,
}

/// The shape of a distribution of errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorShape {
    /// Mean, radians.
    pub mean: f64,
    /// Median, radians.
    pub median: f64,
    /// 90th percentile, radians.
    pub p90: f64,
    /// Share below [`RIGHT_WITHIN`].
    pub right: f64,
}

/// Summarizes trials. Their order changes no bit.
pub fn summarize<'a>(trials: impl IntoIterator<Item = &'a ViewpointTrial>) -> ViewpointSummary {
    let (mut errors, mut largest) = (Vec::new(), Vec::new());
    let mut unanswered = 0;
    for trial in trials {
        // A surface of revolution has no azimuth to find.
        let (Some(error), Some(bound)) = (trial.error(), largest_error(trial.symmetry)) else { continue };
        unanswered += usize::from(trial.found.is_none());
        errors.push(error);
        largest.push(bound);
    }
    errors.sort_by(f64::total_cmp);
    largest.sort_by(f64::total_cmp);
    ViewpointSummary {
        trials: errors.len(),
        unanswered,
        model: model_shape(&errors),
        chance: chance_shape(&largest),
    }
}

/// [`summarize`] by family, in the order of their names.
pub fn summarize_by_family(trials: &[ViewpointTrial]) -> BTreeMap<String, ViewpointSummary> {
    let mut by_family: BTreeMap<String, Vec<&ViewpointTrial>> = BTreeMap::new();
    for trial in trials {
        by_family.entry(trial.family.clone()).or_default().push(trial);
    }
    by_family.into_iter().map(|(family, trials)| (family, summarize(trials))).collect()
}

fn largest_error(symmetry: Symmetry) -> Option<f64> {
    match symmetry {
        Symmetry::None => Some(PI),
        Symmetry::Cyclic { order } => Some(PI / f64::from(order.max(1))),
        Symmetry::Revolution => None,
    }
}

fn model_shape(sorted_errors: &[f64]) -> Option<ErrorShape> {
    let n = sorted_errors.len() as f64;
    Some(ErrorShape {
        mean: sorted_errors.iter().sum::<f64>() / n,
        median: quantile(sorted_errors, 0.5)?,
        p90: quantile(sorted_errors, 0.9)?,
        right: sorted_errors.iter().filter(|&&e| e < RIGHT_WITHIN).count() as f64 / n,
    })
}

/// Of a guess whose error is uniform on `[0, largest]` for each trial.
fn chance_shape(largest: &[f64]) -> Option<ErrorShape> {
    let n = largest.len() as f64;
    let share_below = |error: f64| largest.iter().map(|l| (error / l).min(1.0)).sum::<f64>() / n;
    let inverse = |share: f64| {
        let (mut low, mut high) = (0.0, PI);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if share_below(middle) < share { low = middle } else { high = middle }
        }
        high
    };
    (!largest.is_empty()).then(|| ErrorShape {
        mean: largest.iter().sum::<f64>() / 2.0 / n,
        median: inverse(0.5),
        p90: inverse(0.9),
        right: share_below(RIGHT_WITHIN),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use vantage_dataset::Seed;

    fn trial(symmetry: Symmetry, azimuth: f64, found: Option<f64>) -> ViewpointTrial {
        ViewpointTrial { family: "mug".into(), symmetry, azimuth, found }
    }

    proptest! {
        #[test]
        fn the_peak_of_a_likelihood_is_found(peak in -PI..PI, sharpness in 0.5..200.0f64) {
            let found = most_likely_azimuth(|a| sharpness * (a - peak).cos()).unwrap();
            let error = Symmetry::None.azimuth_distance(found, peak).unwrap();
            prop_assert!(error < 0.1f64.to_radians(), "{found} for {peak}");
        }
    }

    #[test]
    fn a_likelihood_without_preference_or_with_nan_finds_nothing() {
        assert_eq!(most_likely_azimuth(|_| -3.0), None);
        assert_eq!(most_likely_azimuth(|a| if a > 1.0 { f64::NAN } else { a }), None);
    }

    #[test]
    fn truth_as_answer_is_perfect_and_random_answers_are_at_chance() {
        let mut stream = Seed(2).stream("azimuths", 0);
        for symmetry in [Symmetry::None, Symmetry::Cyclic { order: 2 }, Symmetry::Cyclic { order: 4 }] {
            let azimuths: Vec<f64> = (0..4000).map(|_| stream.uniform(-PI, PI)).collect();
            let perfect: Vec<_> = azimuths.iter().map(|&a| trial(symmetry, a, Some(a))).collect();
            let model = summarize(&perfect).model.unwrap();
            assert_eq!((model.median, model.p90, model.right), (0.0, 0.0, 1.0));
            let random: Vec<_> =
                azimuths.iter().map(|&a| trial(symmetry, a, Some(stream.uniform(-PI, PI)))).collect();
            let summary = summarize(&random);
            let (model, chance) = (summary.model.unwrap(), summary.chance.unwrap());
            assert_relative_eq!(model.mean, chance.mean, max_relative = 0.05);
            assert_relative_eq!(model.median, chance.median, max_relative = 0.08);
            assert_relative_eq!(model.p90, chance.p90, max_relative = 0.05);
            assert_relative_eq!(model.right, chance.right, epsilon = 0.03);
        }
    }

    #[test]
    fn chance_of_mixed_symmetries_is_that_of_the_mixture() {
        let none = trial(Symmetry::None, 0.0, Some(0.0));
        assert_relative_eq!(summarize([&none]).chance.unwrap().median, PI / 2.0, epsilon = 1e-9);
        let quarter = trial(Symmetry::Cyclic { order: 4 }, 0.0, Some(0.0));
        // Half the mass below 0.5: x / pi + min(1, 4 x / pi) = 1, so x = pi / 5.
        let mixed = summarize([&none, &quarter]).chance.unwrap();
        assert_relative_eq!(mixed.median, PI / 5.0, epsilon = 1e-9);
        assert_relative_eq!(mixed.mean, (PI / 2.0 + PI / 8.0) / 2.0, epsilon = 1e-12);
    }

    #[test]
    fn no_answer_counts_as_the_worst_and_revolution_is_left_out() {
        let trials = [
            trial(Symmetry::Cyclic { order: 2 }, 1.0, None),
            trial(Symmetry::Revolution, 1.0, Some(0.0)),
            trial(Symmetry::None, 1.0, Some(1.0)),
        ];
        let summary = summarize(&trials);
        assert_eq!((summary.trials, summary.unanswered), (2, 1));
        assert_relative_eq!(summary.model.unwrap().median, PI / 4.0, epsilon = 1e-12);
        let nothing = summarize([&trials[1]]);
        assert_eq!((nothing.trials, nothing.model, nothing.chance), (0, None, None));
    }

    #[test]
    fn families_are_summarized_apart() {
        let mut trials = vec![trial(Symmetry::None, 0.0, Some(0.0)), trial(Symmetry::None, 0.0, Some(2.0))];
        trials[1].family = "book".into();
        let by_family = summarize_by_family(&trials);
        let medians: Vec<_> = by_family.iter().map(|(f, s)| (f.as_str(), s.model.unwrap().median)).collect();
        assert_eq!(medians, [("book", 2.0), ("mug", 0.0)]);
    }
}
