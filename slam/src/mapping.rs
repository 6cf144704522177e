//! Places the objects: triangulation from the robot's first poses, refined with the robot held.

use crate::estimate::{Unresolved, UnresolvedReason};
use crate::graph::Graph;
use crate::initial::{is_in_front, triangulate};
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::solve::{Limits, Outcome, solve};
use crate::variable::{Key, Value, Values};
use nalgebra::Vector3;
use std::collections::BTreeMap;
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
        match place(problem, values, track, of_track) {
            Ok(point) => {
                values.insert(Key::Object(track), Value::Point(point));
                problem.add_offset(values, track);
            }
            Err(reason) => unresolved.push(Unresolved { track, reason }),
        }
    }
    unresolved
}

fn place(
    problem: &Problem<'_>,
    values: &Values,
    track: usize,
    sightings: &[Sighting],
) -> Result<Vector3<f64>, UnresolvedReason> {
    let rays: Vec<Ray> = sightings
        .iter()
        .filter_map(|s| Some(Ray::new(&problem.world_from_camera(values, s.step)?, &s.ray_in_camera)))
        .collect();
    let point = triangulate(&rays, problem.settings.minimum_parallax)?;
    let mut graph = Graph::default();
    problem.add_bearings(&mut graph, track, sightings);
    let mut start = values.clone();
    start.insert(Key::Object(track), Value::Point(point));
    problem.add_offset(&mut start, track);
    let is_free = |key| [Key::Object(track), Key::Offset(track)].contains(&key);
    let refined = solve(&graph, start, is_free, REFINEMENT);
    if matches!(refined.outcome, Outcome::Underconstrained { .. }) {
        return Err(UnresolvedReason::NoParallax);
    }
    refined
        .values
        .get(Key::Object(track))
        .and_then(|value| value.position())
        .filter(|point| point.iter().all(|x| x.is_finite()) && is_in_front(&rays, point))
        .ok_or(UnresolvedReason::BehindCamera)
}
