//! Objects whose crops tell of poses alone, under one of several hypotheses of what the object is: the best one is held.
//!
//! ```text
//! max over X, O and h_i of  P(X, O | U, Z^g)  prod_i P(h_i)  prod_ki p(z^s_ki | h_i, x_rel_ki)
//! ```
//!
//! The hypotheses have equal priors. They are chosen by their cost at their best yaw with the robot held, and again after the
//! joint problem has moved the robot. P(h_i | H) integrates over the object's pose, by Laplace's method about each mode, the robot held.

use super::Geometric;
use crate::association::log_sum;
use crate::estimate::Estimate;
use crate::factor::UprightFactor;
use crate::graph::Graph;
use crate::input::{EstimateError, check_settings};
use crate::orientation::DISTINCT_STEPS;
use crate::posterior::{Posterior, Seen};
use crate::semantics::{SemanticObject, SemanticView, usable};
use crate::settings::{OrientationSettings, SemanticSettings, Settings};
use crate::solve::{Outcome, Solution, solve};
use crate::variable::{Key, Value, Values};
use crate::yaw::{YawMode, yaw_modes};
use nalgebra::{DVector, UnitQuaternion};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use vantage_dataset::{Crop, Observations};
use vantage_model::AnswerError;

/// Most times that hypotheses are chosen anew.
const ROUNDS: usize = 5;

/// What crops tell of an object under each hypothesis.
pub(super) trait Reading {
    /// How many there are.
    fn hypotheses(&self) -> usize;

    /// The numbers of a crop that the factors take; `None` where they are not finite.
    fn measure(&self, crop: &Crop) -> Result<Option<DVector<f64>>, AnswerError>;

    /// Adds the factor of a view.
    fn add<'m>(&'m self, graph: &mut Graph<'m>, hypothesis: usize, of: &Joined<'_>);

    /// What a factor's cost lacks to be comparable between hypotheses, nats.
    fn constant(&self, hypothesis: usize) -> f64;
}

/// What a factor joins.
pub(super) struct Joined<'a> {
    pub(super) keys: [Key; 2],
    pub(super) observations: &'a Observations,
    pub(super) object: &'a SemanticObject,
    pub(super) view: &'a SemanticView,
}

/// The settings of these estimators.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hypotheses {
    geometric: Geometric,
    pub(super) semantics: SemanticSettings,
    orientation: OrientationSettings,
}

/// An object's hypotheses and yaws with the robot held.
#[derive(Clone)]
struct Choice {
    /// Hypotheses with a mode of the yaw, the best first.
    modes: Vec<(usize, YawMode)>,
    /// `log p(z^s | h)` of each hypothesis, nats up to a constant, over its modes; minus infinity where it is defined at none.
    log_evidences: Vec<f64>,
}

/// A solution of the joint problem under a choice.
struct Joint {
    choices: BTreeMap<usize, Choice>,
    solution: Solution,
    /// With the constants of the hypotheses.
    cost: f64,
}

impl Hypotheses {
    pub(super) fn new(settings: &Settings) -> Self {
        let Settings { semantics, orientation, .. } = *settings;
        Self { geometric: Geometric::new(settings), semantics, orientation }
    }

    /// The estimate, and P(h | H) of the objects with usable views, by track.
    pub(super) fn estimate<'m>(
        &self,
        reading: &'m dyn Reading,
        observations: &Observations,
    ) -> Result<(Estimate, BTreeMap<usize, Vec<f64>>), EstimateError> {
        check_settings(&self.semantics)?;
        check_settings(&self.orientation)?;
        let mut posterior: Posterior<'m> = self.geometric.posterior(observations)?;
        let problem = self.geometric.problem(observations);
        let mut objects = BTreeMap::new();
        let Posterior { solution, sightings, dropped, .. } = &mut posterior;
        for (&track, of_track) in &*sightings {
            let measure = |sighting: &crate::sighting::Sighting, _: &_| {
                reading.measure(&observations.detections[sighting.detection].masked_crop)
            };
            let seen = (track, of_track.as_slice());
            let object = usable(&problem, &self.semantics, &solution.values, seen, dropped, measure)?;
            objects.extend(object.map(|object| (track, object)));
        }
        let episode = Episode { told: self, reading, observations, objects };
        let joint = episode.solved(&mut posterior);
        let costs = |track| joint.as_ref().and_then(|joint| joint.choices.get(track));
        let mut beliefs = BTreeMap::new();
        let mut margins = BTreeMap::new();
        for (track, object) in &episode.objects {
            match costs(track) {
                Some(choice) => {
                    beliefs.extend(probabilities(&choice.log_evidences).map(|belief| (*track, belief)));
                    margins.insert(*track, choice.margin());
                }
                None => posterior.dropped.undefined_viewpoint += object.views.len(),
            }
        }
        if let Some(joint) = joint {
            posterior.solution = joint.solution;
        }
        let seen = |track| {
            let object = episode.objects.get(&track)?;
            let margin = Some(*margins.get(&track)?);
            Some(Seen { size: Some(object.size), margin, semantic_views: object.views.len() })
        };
        Ok((self.geometric.estimate_of(posterior, observations, seen), beliefs))
    }
}

/// One episode's objects.
struct Episode<'a, 'm> {
    told: &'a Hypotheses,
    reading: &'m dyn Reading,
    observations: &'a Observations,
    objects: BTreeMap<usize, SemanticObject>,
}

impl<'m> Episode<'_, 'm> {
    /// The best joint solution found, whose factors the posterior's graph then holds; `None` without an object to choose for.
    fn solved(&self, posterior: &mut Posterior<'m>) -> Option<Joint> {
        let kept = posterior.graph.factors().count();
        let mut best: Option<Joint> = None;
        for _ in 0..ROUNDS {
            let values = best.as_ref().map_or(&posterior.solution.values, |joint| &joint.solution.values);
            let choices = self.choices(posterior, values);
            if choices.is_empty() || best.as_ref().is_some_and(|joint| self.agrees(joint, &choices)) {
                break;
            }
            let joint = self.joint(posterior, kept, values.clone(), choices);
            if !is_better(&joint, best.as_ref()) {
                break;
            }
            best = Some(joint);
        }
        let mut best = best?;
        for track in best.ambiguous(&self.told.orientation) {
            let mut choices = best.choices.clone();
            let Some(choice) = choices.get_mut(&track) else { continue };
            choice.modes.swap(0, 1);
            let other = self.joint(posterior, kept, best.solution.values.clone(), choices);
            if is_better(&other, Some(&best)) {
                best = other;
            }
        }
        self.assemble(posterior, kept, &best.choices);
        Some(best)
    }

    /// Every object's hypotheses, the robot held at `values`.
    fn choices(&self, posterior: &Posterior<'m>, values: &Values) -> BTreeMap<usize, Choice> {
        let problem = self.told.geometric.problem(self.observations);
        let of_object = |(&track, object): (&usize, &SemanticObject)| {
            let sightings = posterior.sightings.get(&track)?;
            let (mut modes, mut log_evidences) = (Vec::new(), Vec::new());
            for hypothesis in 0..self.reading.hypotheses() {
                let mut graph = Graph::default();
                problem.add_bearings(&mut graph, track, sightings);
                self.add(&mut graph, object, hypothesis, UnitQuaternion::identity());
                let constant = self.constant(object, hypothesis);
                let mut found = yaw_modes(&graph, &self.told.orientation, track, sightings, values);
                found.iter_mut().for_each(|mode| mode.cost += constant);
                let evidences = found.iter().filter_map(|mode| mode.log_evidence);
                log_evidences.push(log_sum(evidences.map(|evidence| evidence - constant)));
                modes.extend(found.into_iter().map(|mode| (hypothesis, mode)));
            }
            modes.sort_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost));
            (!modes.is_empty()).then_some((track, Choice { modes, log_evidences }))
        };
        self.objects.iter().filter_map(of_object).collect()
    }

    /// The joint problem solved under the first modes of some choices.
    fn joint(
        &self,
        posterior: &mut Posterior<'m>,
        kept: usize,
        mut start: Values,
        choices: BTreeMap<usize, Choice>,
    ) -> Joint {
        self.assemble(posterior, kept, &choices);
        for (&track, choice) in &choices {
            start.insert(Key::Object(track), Value::Pose(choice.modes[0].1.world_from_object));
        }
        let mut solution = solve(&posterior.graph, start, |_| true, self.told.geometric.solver.limits());
        solution.iterations += posterior.solution.iterations;
        let constant = |(track, choice): (&usize, &Choice)| {
            self.objects.get(track).map_or(0.0, |object| self.constant(object, choice.modes[0].0))
        };
        let cost = solution.cost + choices.iter().map(constant).sum::<f64>();
        Joint { choices, solution, cost }
    }

    /// Puts the factors of the first modes after those of geometry.
    fn assemble(&self, posterior: &mut Posterior<'m>, kept: usize, choices: &BTreeMap<usize, Choice>) {
        posterior.graph.truncate(kept);
        for (track, choice) in choices {
            if let (Some(object), Some((hypothesis, mode))) = (self.objects.get(track), choice.modes.first())
            {
                let reference = mode.world_from_object.rotation;
                self.add(&mut posterior.graph, object, *hypothesis, reference);
            }
        }
    }

    fn add(
        &self,
        graph: &mut Graph<'m>,
        object: &SemanticObject,
        hypothesis: usize,
        reference: UnitQuaternion<f64>,
    ) {
        let key = Key::Object(object.track);
        let SemanticSettings { tilt_sigma, yaw_sigma, .. } = self.told.semantics;
        graph.push(UprightFactor::new(key, [tilt_sigma, yaw_sigma], reference));
        for view in &object.views {
            let keys = [Key::Robot(view.sighting.step), key];
            let joined = Joined { keys, observations: self.observations, object, view };
            self.reading.add(graph, hypothesis, &joined);
        }
    }

    fn constant(&self, object: &SemanticObject, hypothesis: usize) -> f64 {
        let scale = self.told.semantics.information_scale;
        scale * self.reading.constant(hypothesis) * object.views.len() as f64
    }

    /// Whether a solution is one of the first modes of some choices already.
    fn agrees(&self, joint: &Joint, choices: &BTreeMap<usize, Choice>) -> bool {
        let near = DISTINCT_STEPS * 2.0 * PI / self.told.orientation.yaw_candidates as f64;
        choices.iter().all(|(track, choice)| {
            let (hypothesis, mode) = choice.modes[0];
            let before = joint.choices.get(track).and_then(|choice| choice.modes.first());
            let pose = joint.solution.values.pose(Key::Object(*track));
            before.is_some_and(|(held, _)| *held == hypothesis)
                && pose.is_some_and(|pose| pose.rotation.angle_to(&mode.world_from_object.rotation) <= near)
        })
    }
}

impl Choice {
    /// Nats to the second mode.
    fn margin(&self) -> f64 {
        match self.modes.as_slice() {
            [(_, best), (_, second), ..] => (second.cost - best.cost).abs(),
            _ => f64::INFINITY,
        }
    }
}

impl Joint {
    /// Tracks whose second mode is near, the nearest first.
    fn ambiguous(&self, settings: &OrientationSettings) -> Vec<usize> {
        let margins = self.choices.iter().map(|(&track, choice)| (choice.margin(), track));
        let mut near: Vec<_> = margins.filter(|(margin, _)| *margin < settings.ambiguous_margin).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.into_iter().take(settings.alternatives).map(|(_, track)| track).collect()
    }
}

fn is_better(joint: &Joint, other: Option<&Joint>) -> bool {
    joint.solution.outcome != Outcome::Diverged && other.is_none_or(|other| joint.cost < other.cost)
        || other.is_none()
}

/// Probabilities of equally likely hypotheses; `None` where none is defined.
fn probabilities(log_evidences: &[f64]) -> Option<Vec<f64>> {
    let all = log_sum(log_evidences.iter().copied());
    all.is_finite().then(|| log_evidences.iter().map(|evidence| libm::exp(evidence - all)).collect())
}
