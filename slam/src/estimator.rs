//! The rows of the score table: start values, problems, and what is made of their solutions.

use crate::covariance::Marginals;
use crate::estimate::{Dropped, Estimate, ObjectEstimate, Orientation, Unresolved, UnresolvedReason};
use crate::factor::Factor;
use crate::graph::Graph;
use crate::initial::dead_reckoning;
use crate::input::{EstimateError, check};
use crate::linear::Structure;
use crate::mapping::place_objects;
use crate::observation_model::{LatentGaussian, ModelError, ObservationModel};
use crate::orientation::{Mode, modes};
use crate::problem::Problem;
use crate::semantics::{SemanticObject, object_size, semantic_object};
use crate::sighting::{Sighting, sightings};
use crate::solve::{Outcome, Solution, solve};
use crate::spec::{EstimatorSpec, Row};
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3};
use std::collections::BTreeMap;
use vantage_dataset::{Observations, Pose};

/// The posterior of an episode by one row's estimator.
///
/// Bad input and a model that does not fit are errors; a problem that has no good answer (nothing observed,
/// under-constrained, diverged) is an [`Outcome`] with the best values there are.
pub fn estimate(
    observations: &Observations,
    row: Row,
    model: Option<&dyn ObservationModel>,
    spec: &EstimatorSpec,
) -> Result<Estimate, EstimateError> {
    check(observations, row, model, spec)?;
    let problem = Problem { observations, spec, row };
    let (mut whole, mut truncated) = sightings(observations);
    if row == Row::Odometry {
        whole.clear();
        truncated.clear();
    }
    let mut dropped = Dropped { truncated: truncated.values().sum(), ..Dropped::default() };

    let mut values = Values::default();
    for (step, pose) in dead_reckoning(observations.steps(), &observations.odometry).into_iter().enumerate() {
        values.insert(Key::Robot(step), Value::Pose(pose));
    }
    let mut unresolved = place_objects(&problem, &mut values, &whole);
    for lost in &unresolved {
        dropped.unresolved += whole.remove(&lost.track).map_or(0, |of_track| of_track.len());
    }
    for &track in truncated.keys() {
        if !whole.contains_key(&track) && !unresolved.iter().any(|lost| lost.track == track) {
            unresolved.push(Unresolved { track, reason: UnresolvedReason::Truncated });
        }
    }
    unresolved.sort_by_key(|lost| lost.track);

    let graph = geometric_graph(&problem, &whole);
    let unanchored = graph.first_unanchored(&values);
    let geometric = solve(&graph, values, |_| true, problem.limits());
    let mut posterior = Posterior { graph, solution: geometric, semantics: BTreeMap::new() };
    if let (true, Some(model)) = (row.is_semantic() && !whole.is_empty(), model) {
        posterior = add_semantics(&problem, model, &whole, posterior, &mut dropped)?;
    }

    let outcome = match (posterior.solution.outcome, unanchored) {
        (_, Some(near)) => Outcome::Underconstrained { near },
        (Outcome::Converged, None) if observations.steps() == 0 => Outcome::NothingObserved,
        (Outcome::Converged, None) if row != Row::Odometry && whole.is_empty() => Outcome::NothingObserved,
        (outcome, None) => outcome,
    };
    Ok(report(&problem, &whole, &posterior, outcome, unresolved, dropped))
}

/// A solved problem over all variables.
struct Posterior<'m> {
    graph: Graph<'m>,
    solution: Solution,
    /// Objects with orientation and latent.
    semantics: BTreeMap<usize, Semantics>,
}

struct Semantics {
    object: SemanticObject,
    /// Modes of the orientation, the chosen one first.
    modes: Vec<Mode>,
    /// Nats to the second mode.
    margin: f64,
}

fn geometric_graph<'m>(problem: &Problem<'_>, sightings: &BTreeMap<usize, Vec<Sighting>>) -> Graph<'m> {
    let mut graph = Graph::default();
    problem.add_odometry(&mut graph);
    for (&track, of_track) in sightings {
        problem.add_bearings(&mut graph, track, of_track);
    }
    graph
}

/// The geometric posterior with orientations, latents and semantic factors added, solved again.
fn add_semantics<'m>(
    problem: &Problem<'_>,
    model: &'m dyn ObservationModel,
    sightings: &BTreeMap<usize, Vec<Sighting>>,
    geometric: Posterior<'m>,
    dropped: &mut Dropped,
) -> Result<Posterior<'m>, ModelError> {
    let mut graph = geometric.graph;
    let mut values = geometric.solution.values;
    let mut semantics = BTreeMap::new();
    for (&track, of_track) in sightings {
        let Some(mut object) = semantic_object(problem, model, &values, track, of_track, dropped)? else {
            continue;
        };
        let modes = match problem.row {
            Row::Uninformative => upright(model, &values, track),
            _ => modes(problem, model, &object, of_track, &values)?,
        };
        let Some(best) = modes.first() else {
            dropped.non_finite += object.views.len();
            continue;
        };
        let mut start = values.clone();
        start.insert(Key::Object(track), Value::Pose(best.world_from_object));
        start.insert(Key::Latent(track), Value::Vector(best.latent.clone()));
        let before = object.views.len();
        let candidates = std::mem::take(&mut object.views);
        object.views = candidates
            .into_iter()
            .filter(|view| problem.semantic_factor(model, &object, view).linearize(&start).is_some())
            .collect();
        dropped.non_finite += before - object.views.len();
        if object.views.is_empty() {
            continue;
        }
        values = start;
        problem.add_semantics(&mut graph, model, &object, &object.views, best.world_from_object.rotation);
        let margin = match (problem.row, modes.get(1)) {
            (Row::Uninformative, _) => 0.0,
            (_, Some(second)) => second.cost - best.cost,
            (_, None) => f64::INFINITY,
        };
        semantics.insert(track, Semantics { object, modes, margin });
    }
    let solution = solve(&graph, values, |_| true, problem.limits());
    let mut posterior = Posterior { graph, solution, semantics };
    try_alternatives(problem, &mut posterior);
    Ok(posterior)
}

/// The single start of an object about which the views say nothing.
fn upright(model: &dyn ObservationModel, values: &Values, track: usize) -> Vec<Mode> {
    let position = values.get(Key::Object(track)).and_then(|value| value.position());
    let mode = |position: Vector3<f64>| Mode {
        world_from_object: Pose::translation(position.x, position.y, position.z),
        latent: DVector::zeros(model.latent_dim()),
        cost: 0.0,
    };
    position.map(mode).into_iter().collect()
}

/// Solves again from the second mode of the most ambiguous objects, one at a time, and keeps what is lower.
fn try_alternatives(problem: &Problem<'_>, posterior: &mut Posterior<'_>) {
    let mut ambiguous: Vec<(f64, usize)> = posterior
        .semantics
        .iter()
        .filter(|(_, s)| s.modes.len() > 1 && s.margin < problem.spec.ambiguous_margin)
        .map(|(&track, s)| (s.margin, track))
        .collect();
    ambiguous.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (_, track) in ambiguous.into_iter().take(problem.spec.alternatives) {
        let Some(semantics) = posterior.semantics.get_mut(&track) else { continue };
        let best = &posterior.solution;
        let Some(position) = best.values.get(Key::Object(track)).and_then(|value| value.position()) else {
            continue;
        };
        let second = &semantics.modes[1];
        let pose = Pose::from_parts(position.into(), second.world_from_object.rotation);
        let mut start = best.values.clone();
        start.insert(Key::Object(track), Value::Pose(pose));
        start.insert(Key::Latent(track), Value::Vector(second.latent.clone()));
        let mut other = solve(&posterior.graph, start, |_| true, problem.limits());
        other.iterations += best.iterations;
        let gain = best.cost - other.cost;
        if gain.is_finite() {
            semantics.margin = gain.abs();
        }
        if gain > 0.0 && other.outcome != Outcome::Diverged {
            semantics.modes.swap(0, 1);
            posterior.solution = other;
        } else {
            posterior.solution.iterations = other.iterations;
        }
    }
}

fn report(
    problem: &Problem<'_>,
    sightings: &BTreeMap<usize, Vec<Sighting>>,
    posterior: &Posterior<'_>,
    outcome: Outcome,
    unresolved: Vec<Unresolved>,
    dropped_detections: Dropped,
) -> Estimate {
    let observations = problem.observations;
    let values = &posterior.solution.values;
    let robots: Vec<Key> = (0..observations.steps()).map(Key::Robot).collect();
    let objects: Vec<Key> = sightings.keys().map(|&track| Key::Object(track)).collect();

    let structure = Structure::new(&posterior.graph, values, |_| true);
    let system = structure.as_ref().and_then(|structure| structure.linearize(&posterior.graph, values));
    let marginals = system.as_ref().and_then(Marginals::new);
    let wanted = marginals.as_ref().filter(|_| problem.spec.covariances);
    let pose_covariances = wanted.and_then(|marginals| {
        let blocks = marginals.covariances(&robots);
        blocks.into_iter().map(|block| Some(Matrix6::from_column_slice(block?.as_slice()))).collect()
    });
    let object_covariances: Vec<Option<DMatrix<f64>>> =
        wanted.map_or_else(|| vec![None; objects.len()], |marginals| marginals.covariances(&objects));

    let mut estimates: Vec<Option<ObjectEstimate>> = vec![None; observations.tracks()];
    for ((&track, of_track), covariance) in sightings.iter().zip(object_covariances) {
        let semantics = posterior.semantics.get(&track);
        let Some(value) = values.get(Key::Object(track)) else { continue };
        let Some(position) = value.position() else { continue };
        let (position_covariance, rotation_covariance) = split(value, covariance.as_ref());
        let latent = semantics.and_then(|_| {
            let mean = values.vector(Key::Latent(track))?.clone();
            let variance = marginals.as_ref()?.latent_variance(Key::Latent(track))?;
            Some(LatentGaussian { mean, variance })
        });
        estimates[track] = Some(ObjectEstimate {
            position,
            position_covariance,
            size: match semantics {
                Some(semantics) => Some(semantics.object.size),
                None => object_size(problem, values, track, of_track),
            },
            orientation: semantics.and_then(|semantics| {
                Some(Orientation {
                    world_from_object: values.pose(Key::Object(track))?.rotation,
                    covariance: rotation_covariance,
                    margin: semantics.margin,
                })
            }),
            latent,
            bearings: of_track.len(),
            semantic_views: semantics.map_or(0, |semantics| semantics.object.views.len()),
        });
    }
    Estimate {
        row: problem.row,
        outcome,
        world_from_robot: robots.iter().filter_map(|&key| values.pose(key).copied()).collect(),
        pose_covariances,
        objects: estimates,
        unresolved,
        iterations: posterior.solution.iterations,
        cost: posterior.solution.cost,
        dropped_detections,
    }
}

/// Covariances of position (world axes) and rotation (right perturbation) from that of a pose or point.
fn split(value: &Value, covariance: Option<&DMatrix<f64>>) -> (Option<Matrix3<f64>>, Option<Matrix3<f64>>) {
    match (value, covariance) {
        (Value::Pose(pose), Some(covariance)) => {
            let world_from_object = pose.rotation.to_rotation_matrix().into_inner();
            let position = Matrix3::from_fn(|i, j| covariance[(3 + i, 3 + j)]);
            let rotation = Matrix3::from_fn(|i, j| covariance[(i, j)]);
            (Some(world_from_object * position * world_from_object.transpose()), Some(rotation))
        }
        (Value::Point(_), Some(covariance)) => {
            (Some(Matrix3::from_column_slice(covariance.as_slice())), None)
        }
        _ => (None, None),
    }
}
