//! P(X, O, E | U, Z^g, Z^s): geometric, with the factors of two views of Eq. 15.

use super::{Estimator, Geometric};
use crate::discrepancy::Discrepant;
use crate::estimate::Estimate;
use crate::factor::semantic::SemanticScaling;
use crate::factor::{Factor, PairFactor, StandardNormalPrior};
use crate::graph::Graph;
use crate::input::{EstimateError, check_model, check_settings};
use crate::orientation::{REFINEMENT, encode, spread};
use crate::posterior::{Posterior, Seen};
use crate::semantics::{SemanticObject, SemanticView, Semantics};
use crate::settings::{OrientationSettings, SemanticSettings, Settings};
use crate::solve::solve;
use crate::variable::{Key, Value, Values};
use std::collections::BTreeMap;
use vantage_dataset::Observations;
use vantage_model::{AnswerError, PairModel};

/// The geometric estimator's factors and, of each object, `P(z | e, x_rel)` of first views and `P(z' | z, e, Delta X)` of Eq. 15 of
/// the others.
///
/// An object is its centre alone: the latent has the world's axes, whose yaw no prior tells from the object's.
#[derive(Clone, Copy)]
pub struct ViewpointPairs<'m> {
    model: &'m dyn PairModel,
    geometric: Geometric,
    semantics: SemanticSettings,
    orientation: OrientationSettings,
}

impl<'m> ViewpointPairs<'m> {
    /// An estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: &'m dyn PairModel) -> Self {
        let Settings { semantics, orientation, .. } = *settings;
        Self { model, geometric: Geometric::new(settings), semantics, orientation }
    }
}

impl Estimator for ViewpointPairs<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        check_settings(&self.semantics)?;
        check_settings(&self.orientation)?;
        check_model(self.model)?;
        let (got, expected) = (self.model.pair_noise().dimension(), self.model.measurement_dim());
        if got != expected {
            let what = "square root of the information of a second view (rows)";
            return Err(AnswerError::Shape { what, got, expected }.into());
        }
        let discrepant = self.semantics.azimuth_discrepancy.map(|of| Discrepant::new(self.model, &of));
        let model: &dyn PairModel = discrepant.as_ref().map_or(self.model, |model| model);
        let mut posterior = self.geometric.posterior(observations)?;
        let problem = self.geometric.problem(observations);
        let pairs = Pairs {
            semantics: Semantics { problem, model, settings: self.semantics, domain: None },
            model,
            orientation: self.orientation,
        };
        let added = pairs.add(&mut posterior)?;
        if !added.is_empty() {
            let Posterior { graph, solution, .. } = &mut posterior;
            let start = std::mem::take(&mut solution.values);
            *solution = solve(graph, start, |_| true, self.geometric.solver.limits());
        }
        let seen = |track| {
            let object: &SemanticObject = added.get(&track)?;
            let margin = Some(f64::INFINITY);
            Some(Seen { size: Some(object.size), margin, semantic_views: object.views.len() })
        };
        let mut estimate = self.geometric.estimate_of(posterior, observations, seen);
        let latents = estimate.objects.iter_mut().flatten().filter_map(|object| object.latent.as_mut());
        latents.for_each(|latent| latent.truncate(self.model.latent_dim()));
        Ok(estimate)
    }
}

/// One episode's crops, and how they pair.
struct Pairs<'a, 'm> {
    semantics: Semantics<'a, 'm>,
    model: &'m dyn PairModel,
    orientation: OrientationSettings,
}

impl<'m> Pairs<'_, 'm> {
    /// Adds latents and semantic factors to a geometric posterior; the objects that have any.
    fn add(&self, posterior: &mut Posterior<'m>) -> Result<BTreeMap<usize, SemanticObject>, AnswerError> {
        let mut added = BTreeMap::new();
        let Posterior { graph, solution, sightings, dropped, .. } = posterior;
        for (&track, of_track) in &*sightings {
            let seen = self.semantics.object(&solution.values, track, of_track, dropped)?;
            let Some(mut object) = seen else { continue };
            let Some(latent) = encode(&self.semantics, &spread(&object.views, self.orientation.views), 0.0)?
            else {
                dropped.non_finite += object.views.len();
                continue;
            };
            let mut values = solution.values.clone();
            values.insert(Key::Latent(track), Value::Vector(latent));
            let before = object.views.len();
            object.views = self.defined(&object, &values);
            dropped.non_finite += before - object.views.len();
            if object.views.is_empty() {
                continue;
            }
            let mut alone = Graph::default();
            self.semantics.problem.add_bearings(&mut alone, track, of_track);
            self.add_factors(&mut alone, &object);
            let is_free = |key| [Key::Object(track), Key::Latent(track), Key::Offset(track)].contains(&key);
            solution.values = solve(&alone, values, is_free, REFINEMENT).values;
            self.add_factors(graph, &object);
            added.insert(track, object);
        }
        Ok(added)
    }

    /// The views whose factors are defined at `values`.
    fn defined(&self, object: &SemanticObject, values: &Values) -> Vec<SemanticView> {
        let mut defined: Vec<SemanticView> = Vec::new();
        for view in &object.views {
            let near = match defined.first() {
                None => self.semantics.factor(object, view).linearize(values),
                Some(first) => self.factor(object, [first, view]).linearize(values),
            };
            if near.is_some() {
                defined.push(view.clone());
            }
        }
        defined
    }

    /// P(e_i), P(z | e_i, x_rel) of the first view, and P(z' | z, e_i, Delta X) of each other one.
    ///
    /// Given the first view and the latent, the others are independent: what is noise of the first one counts once.
    fn add_factors(&self, graph: &mut Graph<'m>, object: &SemanticObject) {
        let [first, others @ ..] = &object.views[..] else { return };
        graph.push(StandardNormalPrior::new(Key::Latent(object.track)));
        graph.push(self.semantics.factor(object, first));
        for second in others {
            graph.push(self.factor(object, [first, second]));
        }
    }

    fn factor(&self, object: &SemanticObject, [first, second]: [&SemanticView; 2]) -> PairFactor<'m> {
        let track = object.track;
        let [a, b] = [first, second].map(|view| Key::Robot(view.sighting.step));
        let SemanticSettings { noise_scale, information_scale, .. } = self.semantics.settings;
        PairFactor::new(
            [a, b, Key::Object(track), Key::Latent(track)],
            self.model,
            [first.measurement.clone(), second.measurement.clone()],
            self.semantics.problem.observations.robot_from_camera,
            object.size,
            SemanticScaling { noise: noise_scale, information: information_scale },
        )
    }
}
