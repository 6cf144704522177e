//! P(X, O, E | U, Z^g, Z^s), with the noise of crops and the model's discrepancy refitted on the run itself: no prediction is changed,
//! only how far it is trusted. What learning while localising has to beat.

use super::{Estimator, Semantic};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::settings::{AzimuthDiscrepancy, SemanticSettings, Settings};
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
        let azimuth_discrepancy = Some(AzimuthDiscrepancy { sigma: of.sigma * factor, ..of });
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
