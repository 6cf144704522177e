//! The control: the variables and factors of the semantic estimator, its semantic factors with zero information.

use super::semantic::{Added, Start, add_semantics};
use super::{Estimator, Geometric};
use crate::estimate::Estimate;
use crate::input::{EstimateError, check_model, check_settings};
use crate::orientation::Mode;
use crate::semantics::{SemanticObject, Semantics};
use crate::settings::{SemanticSettings, Settings};
use crate::sighting::Sighting;
use crate::variable::{Key, Values};
use nalgebra::{DVector, Vector3};
use vantage_dataset::{Observations, Pose};
use vantage_model::ObservationModel;

/// What must equal [`Geometric`] to rounding, though all of the semantic machinery runs.
#[derive(Clone, Copy)]
pub struct Uninformative<'m> {
    model: &'m dyn ObservationModel,
    geometric: Geometric,
    semantics: SemanticSettings,
}

impl<'m> Uninformative<'m> {
    /// A control of the estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: &'m dyn ObservationModel) -> Self {
        let semantics = SemanticSettings { information_scale: 0.0, ..settings.semantics };
        Self { model, geometric: Geometric::new(settings), semantics }
    }
}

impl Estimator for Uninformative<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        check_settings(&self.semantics)?;
        check_model(self.model)?;
        let mut posterior = self.geometric.posterior(observations)?;
        let problem = self.geometric.problem(observations);
        let semantics = Semantics { problem, model: self.model, settings: self.semantics, domain: None };
        // The views say nothing of the orientation: one start, upright, and no second mode to be told from it.
        let start = |object: &SemanticObject, _: &[Sighting], values: &Values| {
            let position = values.get(Key::Object(object.track)).and_then(|value| value.position());
            let upright = |position: Vector3<f64>| Mode {
                world_from_object: Pose::translation(position.x, position.y, position.z),
                latent: DVector::zeros(self.model.latent_dim()),
                cost: 0.0,
            };
            Ok(Start { modes: position.map(upright).into_iter().collect(), margin: 0.0 })
        };
        let added = add_semantics(&semantics, &mut posterior, &self.geometric.solver, |_, _| true, start)?;
        let seen = |track| added.get(&track).map(Added::seen);
        Ok(self.geometric.estimate_of(posterior, observations, seen))
    }
}
