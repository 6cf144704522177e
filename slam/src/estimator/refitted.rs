//! P(X, O, E | U, Z^g, Z^s), with the noise of crops and the model's discrepancy refitted on the run itself: no prediction is changed,
//! only how far it is trusted. What learning while localising has to beat.

use super::{Estimator, Semantic};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::settings::{AzimuthDiscrepancy, SemanticSettings, Settings};
use std::f64::consts::PI;
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// Factors of the spread of the semantic residual that are tried.
const NOISE: [f64; 4] = [1.0, 1.4, 2.0, 2.8];
/// Factors of the discrepancy's deviation that are tried, under the best of those.
const DISCREPANCY: [f64; 2] = [2.0, 4.0];

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
        let by = |semantics: &SemanticSettings| {
            let settings = Settings { semantics: *semantics, ..self.settings };
            Semantic::new(&settings, self.model).evidenced(observations)
        };
        Ok(most_probable(self.settings.semantics, by)?.1)
    }
}

/// A way to read crops, what was made by it, and the evidence of it.
type Tried<T> = (SemanticSettings, T, Option<f64>);

/// The noise and the discrepancy, those that were `told` or larger, of the largest evidence that is defined; those that were told where none
/// is. With them, what was made `by` them.
pub(super) fn most_probable<T>(
    told: SemanticSettings,
    mut by: impl FnMut(&SemanticSettings) -> Result<(T, Option<f64>), EstimateError>,
) -> Result<(SemanticSettings, T), EstimateError> {
    let mut tried = |semantics| by(&semantics).map(|(made, evidence)| (semantics, made, evidence));
    let mut best = tried(told)?;
    for factor in &NOISE[1..] {
        let semantics = SemanticSettings { noise_scale: told.noise_scale * factor, ..told };
        best = more_probable(best, tried(semantics)?);
    }
    let fitted = best.0;
    for factor in DISCREPANCY {
        let Some(of) = fitted.azimuth_discrepancy else { break };
        let azimuth_discrepancy = Some(AzimuthDiscrepancy { sigma: (of.sigma * factor).min(PI), ..of });
        best = more_probable(best, tried(SemanticSettings { azimuth_discrepancy, ..fitted })?);
    }
    Ok((best.0, best.1))
}

/// The more probable of two; the first where neither is known to be.
fn more_probable<T>(own: Tried<T>, other: Tried<T>) -> Tried<T> {
    match (own.2, other.2) {
        (Some(of_own), Some(of_other)) if of_other > of_own => other,
        (None, Some(_)) => other,
        _ => own,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_equals_is_kept_and_what_has_no_evidence_never_is() {
        let told = SemanticSettings { azimuth_discrepancy: None, ..SemanticSettings::default() };
        let by_scale = |evidence: fn(f64) -> Option<f64>| {
            let by = |of: &SemanticSettings| Ok((of.noise_scale, evidence(of.noise_scale)));
            let (semantics, made) = most_probable(told, by).unwrap();
            assert_eq!(semantics.noise_scale, made);
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
        most_probable(told, by).unwrap();
        assert_eq!(tried, [(1.0, 1.0), (1.4, 1.0), (2.0, 1.0), (2.8, 1.0), (2.0, 2.0), (2.0, PI)]);
    }
}
