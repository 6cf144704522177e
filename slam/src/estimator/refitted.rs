//! P(X, O, E | U, Z^g, Z^s), with the noise of crops and the model's discrepancy refitted on the run itself: no prediction is changed,
//! only how far it is trusted. What learning while localising has to beat.

use super::{Estimator, Learner, Learnt, Semantic, gain_a_crop, is_at_maximum};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::{DISCREPANCIES, Lesson, NoiseOdds, SPREADS};
use crate::settings::{AzimuthDiscrepancy, SemanticSettings, Settings};
use std::f64::consts::PI;
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// Factors of the spread of the semantic residual that are tried.
const SPREAD: [f64; SPREADS] = [1.0, 1.4, 2.0, 2.8];
/// Factors of the discrepancy's deviation that are tried, under the best of those.
const DISCREPANCY: [f64; DISCREPANCIES] = [1.0, 2.0, 4.0];

/// [`Semantic`] under the noise and the discrepancy that make what is observed most probable.
pub struct Refitted<'m> {
    settings: Settings,
    model: &'m dyn ObservationModel,
}

impl<'m> Refitted<'m> {
    /// An estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: &'m dyn ObservationModel) -> Self {
        Self { settings: *settings, model }
    }
}

impl Estimator for Refitted<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Ok(self.learn(observations, &Lesson::default())?.estimate)
    }
}

/// By the evidences of all drives so far, those of older ones counting less. Odds of the discrepancy are under the noise of their drive.
impl Learner for Refitted<'_> {
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError> {
        let told = self.settings.semantics;
        let by = |semantics: &SemanticSettings| {
            let settings = Settings { semantics: *semantics, ..self.settings };
            Semantic::new(&settings, self.model).evidenced(observations)
        };
        let (refit, estimate) = most_probable(told, by(&told)?, &before.noise, by)?;
        let known = known_before(told, &before.noise);
        let own = if known == told {
            (None, refit.told)
        } else {
            by(&known).map(|(own, evidence)| (Some(own), evidence))?
        };
        let gain = gain_a_crop((own.0.as_ref().unwrap_or(&estimate), own.1), (&estimate, refit.told));
        // Evidences about no maximum say nothing that a later drive should hear.
        let odds = if is_at_maximum(&estimate) { refit.odds } else { NoiseOdds::default() };
        Ok(Learnt { estimate, lesson: Lesson { noise: before.noise.after(&odds), ..before.clone() }, gain })
    }
}

/// The way to read crops that is most probable by drives before alone.
pub(super) fn known_before(told: SemanticSettings, before: &NoiseOdds) -> SemanticSettings {
    let spread = with_spread(told, SPREAD[likeliest(&before.spread)]);
    with_discrepancy(spread, DISCREPANCY[likeliest(&before.discrepancy)])
}

/// The first of the largest.
pub(super) fn likeliest<const N: usize>(odds: &[f64; N]) -> usize {
    (0..N).rev().max_by(|&a, &b| odds[a].total_cmp(&odds[b])).unwrap_or(0)
}

fn with_spread(told: SemanticSettings, factor: f64) -> SemanticSettings {
    SemanticSettings { noise_scale: told.noise_scale * factor, ..told }
}

fn with_discrepancy(told: SemanticSettings, factor: f64) -> SemanticSettings {
    let azimuth_discrepancy = told.azimuth_discrepancy.map(|of| {
        let sigma = (of.sigma * factor).min(of.sigma.max(PI));
        AzimuthDiscrepancy { sigma, ..of }
    });
    SemanticSettings { azimuth_discrepancy, ..told }
}

/// The noise and the discrepancy that are most probable.
pub(super) struct Refit {
    /// How crops are read by them.
    pub(super) semantics: SemanticSettings,
    /// What this drive says of all that were tried.
    pub(super) odds: NoiseOdds,
    /// The log-evidence of what was told.
    told: Option<f64>,
}

/// What was made by a way to read crops, and the evidence of it.
pub(super) type Tried<T> = (T, Option<f64>);

/// The noise and the discrepancy, those that were `told` or larger, of the largest evidence that is defined, with that of the drives
/// `before`; those that were told, which gave the `first`, where none is. With them, what was made `by` them.
pub(super) fn most_probable<T>(
    told: SemanticSettings,
    first: Tried<T>,
    before: &NoiseOdds,
    mut by: impl FnMut(&SemanticSettings) -> Result<Tried<T>, EstimateError>,
) -> Result<(Refit, T), EstimateError> {
    let of_told = first.1;
    let (semantics, best, of_spread) =
        best_of(SPREAD.map(|factor| with_spread(told, factor)), first, &before.spread, &mut by)?;
    let mut odds = NoiseOdds { spread: of_spread, ..NoiseOdds::default() };
    if semantics.azimuth_discrepancy.is_none() {
        return Ok((Refit { semantics, odds, told: of_told }, best.0));
    }
    let ways = DISCREPANCY.map(|factor| with_discrepancy(semantics, factor));
    let (semantics, best, of_discrepancy) = best_of(ways, best, &before.discrepancy, &mut by)?;
    odds.discrepancy = of_discrepancy;
    Ok((Refit { semantics, odds, told: of_told }, best.0))
}

/// The most probable of several ways to read crops, of which the first was tried, with the log-odds of `before`; and the log-odds of each
/// over the first by this drive alone, 0 where either has none. What has no evidence never is it, but the first where none has.
pub(super) fn best_of<W: Copy, T, const N: usize>(
    ways: [W; N],
    first: Tried<T>,
    before: &[f64; N],
    mut by: impl FnMut(&W) -> Result<Tried<T>, EstimateError>,
) -> Result<(W, Tried<T>, [f64; N]), EstimateError> {
    let told = first.1;
    let mut best = (0, first);
    let mut odds = [0.0; N];
    for (i, way) in ways.iter().enumerate().skip(1) {
        let other = by(way)?;
        if let (Some(of_told), Some(of_other)) = (told, other.1) {
            odds[i] = of_other - of_told;
        }
        let is_better = match (best.1.1, other.1) {
            (Some(own), Some(of_other)) => of_other + before[i] > own + before[best.0],
            (None, Some(_)) => true,
            _ => false,
        };
        if is_better {
            best = (i, other);
        }
    }
    Ok((ways[best.0], best.1, odds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_equals_is_kept_and_what_has_no_evidence_never_is() {
        let told = SemanticSettings { azimuth_discrepancy: None, ..SemanticSettings::default() };
        let by_scale = |evidence: fn(f64) -> Option<f64>| {
            let by = |of: &SemanticSettings| Ok((of.noise_scale, evidence(of.noise_scale)));
            let (refit, made) = most_probable(told, by(&told).unwrap(), &NoiseOdds::default(), by).unwrap();
            assert_eq!(refit.semantics.noise_scale, made);
            made / told.noise_scale
        };
        assert_eq!(by_scale(|_| Some(1.0)), 1.0);
        assert_eq!(by_scale(|_| None), 1.0);
        assert_eq!(by_scale(|scale| (scale > 1.5).then_some(-scale)), 2.0);
        assert_eq!(by_scale(Some), 2.8);
    }

    #[test]
    fn the_discrepancy_is_tried_under_the_best_noise_and_stays_within_half_a_turn() {
        let azimuth_discrepancy = Some(AzimuthDiscrepancy { sigma: 1.0, concentration: 4.0 });
        let told = SemanticSettings { azimuth_discrepancy, ..SemanticSettings::default() };
        let mut tried = Vec::new();
        let by = |of: &SemanticSettings| {
            tried.push((of.noise_scale, of.azimuth_discrepancy.map_or(0.0, |of| of.sigma)));
            Ok(((), Some(-(of.noise_scale - 2.0).abs())))
        };
        most_probable(told, ((), Some(-1.0)), &NoiseOdds::default(), by).unwrap();
        assert_eq!(tried, [(1.4, 1.0), (2.0, 1.0), (2.8, 1.0), (2.0, 2.0), (2.0, PI)]);
    }

    #[test]
    fn what_drives_before_say_counts() {
        let told = SemanticSettings { azimuth_discrepancy: None, ..SemanticSettings::default() };
        let by = |of: &SemanticSettings| Ok(((), Some(-of.noise_scale / told.noise_scale)));
        let after = |before: &NoiseOdds| most_probable(told, by(&told).unwrap(), before, by).unwrap().0;
        let first = after(&NoiseOdds::default());
        assert_eq!(first.semantics.noise_scale, told.noise_scale);
        assert_eq!(first.odds.spread.map(|odds| (odds * 10.0).round()), [0.0, -4.0, -10.0, -18.0]);
        let before = NoiseOdds { spread: [0.0, 0.0, 1.5, 1.5], ..NoiseOdds::default() };
        assert_eq!(after(&before).semantics.noise_scale, 2.0 * told.noise_scale);
    }
}
