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

/// A way to read crops, and what came of it.
struct Tried {
    semantics: SemanticSettings,
    estimate: Estimate,
    evidence: Option<f64>,
}

impl<'m> Refitted<'m> {
    /// An estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: &'m dyn ObservationModel) -> Self {
        Self { settings: *settings, model }
    }

    fn tried(
        &self,
        semantics: SemanticSettings,
        observations: &Observations,
    ) -> Result<Tried, EstimateError> {
        let settings = Settings { semantics, ..self.settings };
        let (estimate, evidence) = Semantic::new(&settings, self.model).evidenced(observations)?;
        Ok(Tried { semantics, estimate, evidence })
    }
}

impl Estimator for Refitted<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        let told = self.settings.semantics;
        let mut best = self.tried(told, observations)?;
        for factor in &NOISE[1..] {
            let semantics = SemanticSettings { noise_scale: told.noise_scale * factor, ..told };
            best = best.or(self.tried(semantics, observations)?);
        }
        let fitted = best.semantics;
        for factor in DISCREPANCY {
            let Some(of) = fitted.azimuth_discrepancy else { break };
            let azimuth_discrepancy = Some(AzimuthDiscrepancy { sigma: of.sigma * factor, ..of });
            best = best.or(self.tried(SemanticSettings { azimuth_discrepancy, ..fitted }, observations)?);
        }
        Ok(best.estimate)
    }
}

impl Tried {
    /// The more probable of two; itself where neither is known to be.
    fn or(self, other: Self) -> Self {
        match (self.evidence, other.evidence) {
            (Some(own), Some(others)) if others > own => other,
            (None, Some(_)) => other,
            _ => self,
        }
    }
}
