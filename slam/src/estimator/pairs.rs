//! P(X, O, E | U, Z^g, Z^s): geometric, with the factors of two views of Eq. 15.

use super::{Estimator, Geometric};
use crate::discrepancy::Discrepant;
use crate::estimate::Estimate;
use crate::factor::semantic::SemanticScaling;
use crate::factor::{Factor, LinearFactor, PairFactor, StandardNormalPrior};
use crate::graph::Graph;
use crate::input::{EstimateError, check_model, check_settings};
use crate::noisy_first::NoisyFirst;
use crate::orientation::{REFINEMENT, encode, spread};
use crate::pairing::Pairing;
use crate::posterior::{Posterior, Seen};
use crate::semantics::{SemanticObject, SemanticView, Semantics};
use crate::settings::{OrientationSettings, SemanticSettings, Settings};
use crate::solve::solve;
use crate::variable::{Key, Value, Values};
use std::collections::BTreeMap;
use vantage_dataset::Observations;
use vantage_model::{AnswerError, PairModel};

/// The geometric estimator's factors and, of each object, `P(z' | z, e, Delta X)` of Eq. 15 of views that are given another one, and
/// `P(z | e, x_rel)` of the rest.
///
/// An object is its centre alone: the latent has the world's axes, whose yaw no prior tells from the object's.
#[derive(Clone, Copy)]
pub struct ViewpointPairs<'m> {
    model: &'m dyn PairModel,
    pairing: Pairing,
    geometric: Geometric,
    semantics: SemanticSettings,
    orientation: OrientationSettings,
}

impl<'m> ViewpointPairs<'m> {
    /// An estimator that reads crops by `model`, each given the one of its object before.
    pub fn new(settings: &Settings, model: &'m dyn PairModel) -> Self {
        let Settings { semantics, orientation, .. } = *settings;
        Self { model, pairing: Pairing::Chain, geometric: Geometric::new(settings), semantics, orientation }
    }

    /// The same by another pairing.
    pub fn paired(self, pairing: Pairing) -> Self {
        Self { pairing, ..self }
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
        let noisy = match self.pairing {
            Pairing::NoisyStar(share) if !(0.0..1.0).contains(&share) => {
                let report =
                    format!("a first view's own share of its noise: got {share}, expected 0 to below 1");
                return Err(EstimateError::Spec { report });
            }
            Pairing::NoisyStar(share) => Some(NoisyFirst::new(model, share, self.semantics.noise_scale)?),
            _ => None,
        };
        let model: &dyn PairModel = noisy.as_ref().map_or(model, |model| model);
        let mut posterior = self.geometric.posterior(observations)?;
        let problem = self.geometric.problem(observations);
        let pairs = Pairs {
            semantics: Semantics { problem, model, settings: self.semantics, domain: None },
            model,
            pairing: self.pairing,
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
    pairing: Pairing,
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
        let mut views = object.views.clone();
        let is_undefined = |views: &[SemanticView], index| {
            let near: Option<LinearFactor> = match self.pairing.given(index, views.len()) {
                None => self.semantics.factor(object, &views[index]).linearize(values),
                Some(given) => self.factor(object, [&views[given], &views[index]]).linearize(values),
            };
            near.is_none()
        };
        while let Some(undefined) = (0..views.len()).find(|&index| is_undefined(&views, index)) {
            views.remove(undefined);
        }
        views
    }

    /// P(e_i), and of each view P(z' | z, e_i, Delta X) where it is given another one, or else P(z | e_i, x_rel).
    ///
    /// Every view is predicted once, so that the product is the density of all of them: of a chain, one of Markov's.
    fn add_factors(&self, graph: &mut Graph<'m>, object: &SemanticObject) {
        graph.push(StandardNormalPrior::new(Key::Latent(object.track)));
        for (index, view) in object.views.iter().enumerate() {
            match self.pairing.given(index, object.views.len()) {
                None => graph.push(self.semantics.factor(object, view)),
                Some(given) => graph.push(self.factor(object, [&object.views[given], view])),
            }
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
