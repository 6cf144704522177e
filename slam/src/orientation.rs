//! First orientations: a grid of viewpoints scored by the decoder over an object's views, best modes refined.

use crate::graph::Graph;
use crate::semantics::{SemanticObject, SemanticView, Semantics, unless_non_finite};
use crate::settings::OrientationSettings;
use crate::sighting::Sighting;
use crate::solve::{Limits, solve};
use crate::variable::{Key, Value, Values};
use nalgebra::{DVector, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use vantage_dataset::Pose;
use vantage_model::{AnswerError, Information};

/// A few steps of the latent alone: the encoder reads a wrong latent from far views, and a good yaw would be
/// judged by it.
const RECONSIDERATION: Limits = Limits { iterations: 3, tolerance: 1e-3 };
/// Minima of the grid that are reconsidered, per mode that is refined.
const RECONSIDERED: usize = 3;
/// Enough to tell modes apart; the joint problem does the rest.
pub(crate) const REFINEMENT: Limits = Limits { iterations: 10, tolerance: 1e-4 };
/// Modes nearer than this many grid steps are one.
pub(crate) const DISTINCT_STEPS: f64 = 2.0;

/// One mode of an object's orientation.
#[derive(Clone, Debug)]
pub struct Mode {
    /// The object, refined with the robot held.
    pub world_from_object: Pose,
    /// Its latent.
    pub latent: DVector<f64>,
    /// Negative log-posterior given the robot's poses, nats up to a constant shared by an object's modes.
    pub cost: f64,
}

/// An object's distinct modes, the best first; empty where the model answers none with finite numbers.
///
/// Each yaw of the grid gets the latent that the encoder reads from the views under it (the product of their
/// posteriors with the prior), and is scored by the graph's own cost of the object: bearings, priors and the
/// Student-t of every view. The best local minima over the circle are judged again after a few steps of the
/// latent, and the best of those are refined, object and latent together.
pub fn modes(
    semantics: &Semantics<'_, '_>,
    settings: &OrientationSettings,
    object: &SemanticObject,
    sightings: &[Sighting],
    values: &Values,
) -> Result<Vec<Mode>, AnswerError> {
    let track = object.track;
    let views = spread(&object.views, settings.views);
    let mut graph = Graph::default();
    semantics.problem.add_bearings(&mut graph, track, sightings);
    semantics.add_factors(&mut graph, object, &views, UnitQuaternion::identity());
    let known: Vec<(Key, Value)> = sightings
        .iter()
        .map(|s| Key::Robot(s.step))
        .chain([Key::Offset(track)])
        .filter_map(|key| Some((key, values.get(key)?.clone())))
        .collect();
    let Some(position) = values.get(Key::Object(track)).and_then(|value| value.position()) else {
        return Ok(Vec::new());
    };

    let count = settings.yaw_candidates;
    let step = 2.0 * PI / count as f64;
    let mut grid = Vec::with_capacity(count);
    for index in 0..count {
        let yaw = index as f64 * step;
        let Some(latent) = encode(semantics, &views, yaw)? else {
            grid.push(None);
            continue;
        };
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        let mut start = Values::default();
        for (key, value) in &known {
            start.insert(*key, value.clone());
        }
        start.insert(Key::Object(track), Value::Pose(Pose::from_parts(position.into(), rotation)));
        start.insert(Key::Latent(track), Value::Vector(latent));
        grid.push(graph.cost(&start).map(|cost| (cost, start)));
    }

    let refined_modes = settings.refined_modes;
    let mut shortlist: Vec<_> = local_minima(&grid)
        .into_iter()
        .take(RECONSIDERED * refined_modes)
        .map(|start| solve(&graph, start, |key| matches!(key, Key::Latent(_)), RECONSIDERATION))
        .collect();
    shortlist.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut modes: Vec<Mode> = shortlist
        .into_iter()
        .take(refined_modes)
        .filter_map(|start| {
            let refined = solve(&graph, start.values, |key| !matches!(key, Key::Robot(_)), REFINEMENT);
            Some(Mode {
                world_from_object: *refined.values.pose(Key::Object(track))?,
                latent: refined.values.vector(Key::Latent(track))?.clone(),
                cost: refined.cost,
            })
        })
        .collect();
    modes.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut distinct: Vec<Mode> = Vec::new();
    for mode in modes {
        let turn = |other: &Mode| other.world_from_object.rotation.angle_to(&mode.world_from_object.rotation);
        if distinct.iter().all(|other| turn(other) > DISTINCT_STEPS * step) {
            distinct.push(mode);
        }
    }
    Ok(distinct)
}

/// The mean latent of the views if the object's yaw is `yaw`.
pub(crate) fn encode(
    semantics: &Semantics<'_, '_>,
    views: &[SemanticView],
    yaw: f64,
) -> Result<Option<DVector<f64>>, AnswerError> {
    let dim = semantics.model.latent_dim();
    let mut posteriors = Vec::with_capacity(views.len());
    for view in views {
        let crop = semantics.crop(&view.sighting);
        match unless_non_finite(semantics.model.encode(crop, &view.viewpoint.turned(-yaw)))? {
            Some(posterior) if posterior.is_valid(dim) => posteriors.push(posterior),
            _ => return Ok(None),
        }
    }
    let Information { precision, weighted_mean } = Information::of(dim, &posteriors);
    Ok(Some(precision.map(f64::recip).component_mul(&weighted_mean)))
}

/// At most `most` views, evenly spread over their order.
pub(crate) fn spread(views: &[SemanticView], most: usize) -> Vec<SemanticView> {
    if views.len() <= most {
        return views.to_vec();
    }
    (0..most).map(|i| views[(2 * i + 1) * views.len() / (2 * most)].clone()).collect()
}

/// The points of a circular grid that are lower than the one before and not higher than the one after, the
/// lowest first.
pub(crate) fn local_minima<T: Clone>(grid: &[Option<(f64, T)>]) -> Vec<T> {
    let cost = |index: usize| match &grid[index % grid.len()] {
        Some((cost, _)) => *cost,
        None => f64::INFINITY,
    };
    let mut minima: Vec<(f64, T)> = (0..grid.len())
        .filter(|&i| cost(i) < cost(i + grid.len() - 1) && cost(i) <= cost(i + 1))
        .filter_map(|i| grid[i].clone())
        .collect();
    if minima.is_empty() {
        minima.extend(grid.iter().flatten().next().cloned());
    }
    minima.sort_by(|a, b| a.0.total_cmp(&b.0));
    minima.into_iter().map(|(_, point)| point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minima_are_found_across_the_seam_and_sorted() {
        let grid = |costs: &[f64]| {
            let points = costs.iter().enumerate();
            points.map(|(i, &c)| c.is_finite().then_some((c, i))).collect::<Vec<_>>()
        };
        assert_eq!(local_minima(&grid(&[1.0, 2.0, 5.0, 0.5, 4.0, 3.0])), [3, 0]);
        assert_eq!(local_minima(&grid(&[2.0, 2.0, 2.0])), [0]);
        assert_eq!(local_minima(&grid(&[f64::NAN, 3.0, f64::NAN, 2.0])), [3, 1]);
        assert!(local_minima(&grid(&[f64::NAN; 4])).is_empty());
    }
}
