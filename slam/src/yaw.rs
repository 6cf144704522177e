//! First orientations of an object whose factors have no latent: a grid of yaws, best modes refined.

use crate::graph::Graph;
use crate::laplace::log_evidence;
use crate::orientation::{DISTINCT_STEPS, REFINEMENT, local_minima};
use crate::settings::OrientationSettings;
use crate::sighting::Sighting;
use crate::solve::solve;
use crate::variable::{Key, Value, Values};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::PI;
use vantage_dataset::Pose;

/// One mode of an object's orientation.
#[derive(Clone, Copy, Debug)]
pub struct YawMode {
    /// The object, refined with the robot held.
    pub world_from_object: Pose,
    /// Negative log-posterior given the robot's poses, nats up to a constant shared by an object's modes.
    pub cost: f64,
    /// `log` of the integral of `exp(-cost)` about the mode, by Laplace's method; `None` where that is not defined.
    pub log_evidence: Option<f64>,
}

/// An object's distinct modes under `graph`, the factors of the object alone, the best first; empty where the factors are defined
/// at no yaw.
pub fn yaw_modes(
    graph: &Graph<'_>,
    settings: &OrientationSettings,
    track: usize,
    sightings: &[Sighting],
    values: &Values,
) -> Vec<YawMode> {
    let Some(position) = values.get(Key::Object(track)).and_then(|value| value.position()) else {
        return Vec::new();
    };
    let mut held = Values::default();
    for key in sightings.iter().map(|sighting| Key::Robot(sighting.step)) {
        if let Some(value) = values.get(key) {
            held.insert(key, value.clone());
        }
    }
    let step = 2.0 * PI / settings.yaw_candidates as f64;
    let at = |index: usize| {
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), index as f64 * step);
        let mut start = held.clone();
        start.insert(Key::Object(track), Value::Pose(Pose::from_parts(position.into(), rotation)));
        graph.cost(&start).map(|cost| (cost, start))
    };
    let grid: Vec<_> = (0..settings.yaw_candidates).map(at).collect();
    let mut modes: Vec<YawMode> = local_minima(&grid)
        .into_iter()
        .take(settings.refined_modes)
        .filter_map(|start| {
            let refined = solve(graph, start, |key| key == Key::Object(track), REFINEMENT);
            let world_from_object = *refined.values.pose(Key::Object(track))?;
            let log_evidence = log_evidence(graph, &refined.values, &[Key::Object(track)]);
            refined.cost.is_finite().then_some(YawMode {
                world_from_object,
                cost: refined.cost,
                log_evidence,
            })
        })
        .collect();
    modes.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut distinct: Vec<YawMode> = Vec::new();
    for mode in modes {
        let turn =
            |other: &YawMode| other.world_from_object.rotation.angle_to(&mode.world_from_object.rotation);
        if distinct.iter().all(|other| turn(other) > DISTINCT_STEPS * step) {
            distinct.push(mode);
        }
    }
    distinct
}
