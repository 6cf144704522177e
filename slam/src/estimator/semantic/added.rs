//! Objects that semantic factors are of: how they join a posterior, and the second modes of their orientations.

use crate::factor::Factor;
use crate::orientation::Mode;
use crate::posterior::{Posterior, Seen};
use crate::semantics::{SemanticObject, Semantics};
use crate::settings::{OrientationSettings, SolverSettings};
use crate::sighting::Sighting;
use crate::solve::{Outcome, solve};
use crate::variable::{Key, Value, Values};
use std::collections::BTreeMap;
use vantage_dataset::Pose;
use vantage_model::AnswerError;

/// Where the search for an object's orientation and latent starts.
pub(in crate::estimator) struct Start {
    /// Modes of the orientation, the best first.
    pub(in crate::estimator) modes: Vec<Mode>,
    /// Nats to the second mode.
    pub(in crate::estimator) margin: f64,
}

/// An object with orientation, latent and semantic factors.
pub(in crate::estimator) struct Added {
    pub(super) object: SemanticObject,
    start: Start,
}

impl Added {
    pub(in crate::estimator) fn seen(&self) -> Seen {
        let (size, semantic_views) = (Some(self.object.size), self.object.views.len());
        Seen { size, margin: Some(self.start.margin), semantic_views }
    }
}

/// Adds orientations, latents and semantic factors to a geometric posterior, of the views of tracks that it
/// `reads`, and solves again.
pub(in crate::estimator) fn add_semantics<'m>(
    semantics: &Semantics<'_, 'm>,
    posterior: &mut Posterior<'m>,
    solver: &SolverSettings,
    reads: impl Fn(usize, &Sighting) -> bool,
    start: impl Fn(&SemanticObject, &[Sighting], &Values) -> Result<Start, AnswerError>,
) -> Result<BTreeMap<usize, Added>, AnswerError> {
    let mut added = BTreeMap::new();
    let Posterior { graph, solution, sightings, dropped, .. } = posterior;
    if sightings.is_empty() {
        return Ok(added);
    }
    let mut values = solution.values.clone();
    for (&track, of_track) in sightings.iter() {
        if !of_track.iter().any(|sighting| reads(track, sighting)) {
            continue;
        }
        let Some(mut object) = semantics.object(&values, track, of_track, dropped)? else { continue };
        object.views.retain(|view| reads(track, &view.sighting));
        if object.views.is_empty() {
            continue;
        }
        let start = start(&object, of_track, &values)?;
        let Some(best) = start.modes.first() else {
            dropped.non_finite += object.views.len();
            continue;
        };
        let mut moved = values.clone();
        moved.insert(Key::Object(track), Value::Pose(best.world_from_object));
        moved.insert(Key::Latent(track), Value::Vector(best.latent.clone()));
        let candidates = std::mem::take(&mut object.views);
        let before = candidates.len();
        object.views = candidates
            .into_iter()
            .filter(|view| semantics.factor(&object, view).linearize(&moved).is_some())
            .collect();
        dropped.non_finite += before - object.views.len();
        if object.views.is_empty() {
            continue;
        }
        values = moved;
        semantics.add_factors(graph, &object, &object.views, best.world_from_object.rotation);
        added.insert(track, Added { object, start });
    }
    *solution = solve(graph, values, |_| true, solver.limits());
    Ok(added)
}

/// Solves again from the second mode of the most ambiguous objects, one at a time, and keeps what is lower.
pub(super) fn try_alternatives(
    posterior: &mut Posterior<'_>,
    added: &mut BTreeMap<usize, Added>,
    solver: &SolverSettings,
    settings: &OrientationSettings,
) {
    let is_ambiguous = |start: &Start| start.modes.len() > 1 && start.margin < settings.ambiguous_margin;
    let mut ambiguous: Vec<(f64, usize)> = added
        .iter()
        .filter(|(_, added)| is_ambiguous(&added.start))
        .map(|(&track, added)| (added.start.margin, track))
        .collect();
    ambiguous.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (_, track) in ambiguous.into_iter().take(settings.alternatives) {
        let Some(Added { start: Start { modes, margin }, .. }) = added.get_mut(&track) else { continue };
        let best = &posterior.solution;
        let Some(position) = best.values.get(Key::Object(track)).and_then(|value| value.position()) else {
            continue;
        };
        let second = &modes[1];
        let pose = Pose::from_parts(position.into(), second.world_from_object.rotation);
        let mut start = best.values.clone();
        start.insert(Key::Object(track), Value::Pose(pose));
        start.insert(Key::Latent(track), Value::Vector(second.latent.clone()));
        let mut other = solve(&posterior.graph, start, |_| true, solver.limits());
        other.iterations += best.iterations;
        let gain = best.cost - other.cost;
        if gain.is_finite() {
            *margin = gain.abs();
        }
        if gain > 0.0 && other.outcome != Outcome::Diverged {
            modes.swap(0, 1);
            posterior.solution = other;
        } else {
            posterior.solution.iterations = other.iterations;
        }
    }
}
