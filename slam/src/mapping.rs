//! Places objects and landmarks: triangulation from the robot's first poses, or depths where there are any, refined with the
//! robot held.

use crate::estimate::{Dropped, Unresolved, UnresolvedLandmark, UnresolvedReason};
use crate::graph::Graph;
use crate::initial::{is_in_front, triangulate};
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::solve::{Limits, Outcome, solve};
use crate::variable::{Key, Value, Values};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use vantage_dataset::LandmarkSighting;
use vantage_dataset::ray::Ray;

/// A start value needs no more.
const REFINEMENT: Limits = Limits { iterations: 20, tolerance: 1e-6 };

/// Adds to `values` the centre of every object that its sightings place, with the offset of its boxes where that is a variable; returns the others.
pub fn place_objects(
    problem: &Problem<'_>,
    values: &mut Values,
    sightings: &BTreeMap<usize, Vec<Sighting>>,
) -> Vec<Unresolved> {
    let mut unresolved = Vec::new();
    for (&track, of_track) in sightings {
        match place_object(problem, values, track, of_track) {
            Ok(point) => {
                values.insert(Key::Object(track), Value::Point(point));
                problem.add_offset(values, track);
            }
            Err(reason) => unresolved.push(Unresolved { track, reason }),
        }
    }
    unresolved
}

/// Adds to `values` every landmark that its sightings place, keeps in `sightings` what the first values have in front of the
/// camera, counts the rest in `dropped`, and returns the landmarks that are not placed.
pub fn place_landmarks(
    problem: &Problem<'_>,
    values: &mut Values,
    sightings: &mut BTreeMap<usize, Vec<LandmarkSighting>>,
    dropped: &mut Dropped,
) -> Vec<UnresolvedLandmark> {
    let mut unresolved = Vec::new();
    sightings.retain(|&landmark, seen| {
        let before = seen.len();
        match place_landmark(problem, values, landmark, seen) {
            Ok(point) => {
                values.insert(Key::Landmark(landmark), Value::Point(point));
                dropped.landmark_behind_camera += before - seen.len();
                true
            }
            Err(reason) => {
                unresolved.push(UnresolvedLandmark { landmark, reason });
                dropped.unresolved_landmark += before;
                false
            }
        }
    });
    unresolved
}

/// Where an object's sightings have it.
pub(crate) fn place_object(
    problem: &Problem<'_>,
    values: &Values,
    track: usize,
    sightings: &[Sighting],
) -> Result<Vector3<f64>, UnresolvedReason> {
    let rays: Vec<Ray> = sightings
        .iter()
        .filter_map(|s| Some(Ray::new(&problem.world_from_camera(values, s.step)?, &s.ray_in_camera)))
        .collect();
    let point = match at_depth(problem, values, sightings) {
        Some(point) => point,
        None => triangulate(&rays, problem.settings.minimum_parallax)?,
    };
    let mut graph = Graph::default();
    problem.add_bearings(&mut graph, track, sightings);
    let steps = sightings.iter().map(|s| s.step);
    let mut start = robots(values, steps);
    problem.add_offset(&mut start, track);
    refined(&graph, Key::Object(track), point, start, &rays)
}

/// The mean of where the sightings with depth have an object; `None` where there is none.
fn at_depth(problem: &Problem<'_>, values: &Values, sightings: &[Sighting]) -> Option<Vector3<f64>> {
    let points: Vec<Vector3<f64>> = sightings
        .iter()
        .filter_map(|s| {
            let p_in_camera = s.ray_in_camera * s.depth?.meters;
            let world_from_camera = problem.world_from_camera(values, s.step)?;
            Some(world_from_camera.transform_point(&p_in_camera.into()).coords)
        })
        .collect();
    (!points.is_empty()).then(|| points.iter().sum::<Vector3<f64>>() / points.len() as f64)
}

/// Where a landmark is; leaves in `sightings` those that have it in front of the camera.
pub(crate) fn place_landmark(
    problem: &Problem<'_>,
    values: &Values,
    landmark: usize,
    sightings: &mut Vec<LandmarkSighting>,
) -> Result<Vector3<f64>, UnresolvedReason> {
    let camera = problem.observations.camera;
    let rays: Vec<Ray> = sightings
        .iter()
        .filter_map(|s| {
            Some(Ray::new(&problem.world_from_camera(values, s.step)?, &camera.ray_in_camera(&s.pixel)))
        })
        .collect();
    let point = triangulate(&rays, problem.settings.minimum_parallax)?;
    sightings.retain(|sighting| {
        problem
            .world_from_camera(values, sighting.step)
            .is_some_and(|world_from_camera| world_from_camera.inverse_transform_point(&point.into()).z > 0.0)
    });
    if sightings.len() < 2 {
        return Err(UnresolvedReason::BehindCamera);
    }
    let mut graph = Graph::default();
    problem.add_projections(&mut graph, sightings);
    let steps = sightings.iter().map(|s| s.step);
    refined(&graph, Key::Landmark(landmark), point, robots(values, steps), &rays)
}

/// The robot's poses at some steps.
pub(crate) fn robots(values: &Values, steps: impl Iterator<Item = usize>) -> Values {
    let mut robots = Values::default();
    for key in steps.map(Key::Robot) {
        if let Some(value) = values.get(key) {
            robots.insert(key, value.clone());
        }
    }
    robots
}

/// The point that a graph of its own factors has best, the robot held.
fn refined(
    graph: &Graph<'_>,
    key: Key,
    point: Vector3<f64>,
    mut start: Values,
    rays: &[Ray],
) -> Result<Vector3<f64>, UnresolvedReason> {
    start.insert(key, Value::Point(point));
    let refined = solve(graph, start, |key| !matches!(key, Key::Robot(_)), REFINEMENT);
    if matches!(refined.outcome, Outcome::Underconstrained { .. }) {
        return Err(UnresolvedReason::NoParallax);
    }
    refined
        .values
        .get(key)
        .and_then(|value| value.position())
        .filter(|point| point.iter().all(|x| x.is_finite()) && is_in_front(rays, point))
        .ok_or(UnresolvedReason::BehindCamera)
}
