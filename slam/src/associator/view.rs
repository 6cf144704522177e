//! The views of a tracklet, as likenesses read them.

use super::scan::level;
use crate::problem::Problem;
use crate::semantics::unless_non_finite;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::{DVector, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{Crop, Pose, Viewpoint};
use vantage_model::AnswerError;

/// Yaws of an object that are summed over.
pub(super) const YAWS: usize = 48;

/// A crop, and from where it was taken if the object has yaw 0.
pub(super) struct View<'a> {
    pub crop: &'a Crop,
    pub viewpoint: Viewpoint,
}

/// At most so many views of track 0, spread over its sightings; none where its place does not tell a viewpoint.
pub(super) fn views<'a>(
    problem: &Problem<'a>,
    values: &Values,
    sightings: &[Sighting],
    most: usize,
) -> Vec<View<'a>> {
    let position = values.get(Key::Object(0)).and_then(|value| value.position());
    let size = problem.object_size(values, 0, sightings);
    let (Some(position), Some(size)) = (position, size) else { return Vec::new() };
    let upright = Pose::translation(position.x, position.y, position.z);
    let (n, most) = (sightings.len(), most.max(1));
    let view = |i: usize| {
        let sighting = &sightings[if n <= most { i } else { (2 * i + 1) * n / (2 * most) }];
        let world_from_camera = problem.world_from_camera(values, sighting.step)?;
        let viewpoint = Viewpoint::new(&upright.inv_mul(&world_from_camera), size)?;
        Some(View { crop: &problem.observations.detections[sighting.detection].masked_crop, viewpoint })
    };
    (0..n.min(most)).filter_map(view).collect()
}

/// Those that a model measures with finite numbers.
pub(super) fn measured<'a>(
    views: Vec<View<'a>>,
    measure: impl Fn(&Crop) -> Result<DVector<f64>, AnswerError>,
) -> Result<Vec<(View<'a>, DVector<f64>)>, AnswerError> {
    let mut measured = Vec::with_capacity(views.len());
    for view in views {
        if let Some(measurement) = unless_non_finite(measure(view.crop))? {
            measured.push((view, measurement));
        }
    }
    Ok(measured)
}

/// What a likeness reads a tracklet by: its poses in the upright frame of the first, and its object at a place of the world as track 0. `None` where
/// there is no first pose.
pub(super) fn own_frame(
    sightings: &[Sighting],
    place: Vector3<f64>,
    pose: impl Fn(usize) -> Option<Pose>,
) -> Option<Values> {
    let level = level(&pose(sightings.first()?.step)?);
    let mut values = Values::default();
    let there = level.inverse_transform_point(&place.into()).coords;
    values.insert(Key::Object(0), Value::Point(there));
    for sighting in sightings {
        if let Some(pose) = pose(sighting.step) {
            values.insert(Key::Robot(sighting.step), Value::Pose(level.inv_mul(&pose)));
        }
    }
    Some(values)
}

/// The yaws, radians.
pub(super) fn yaws() -> impl Iterator<Item = f64> {
    (0..YAWS).map(|k| 2.0 * PI * k as f64 / YAWS as f64)
}

/// `log(exp a + exp b)`.
pub(super) fn log_sum(a: f64, b: f64) -> f64 {
    let largest = a.max(b);
    largest + libm::log(libm::exp(a - largest) + libm::exp(b - largest))
}

/// `log` of the mean of exponentials.
pub(super) fn log_mean(logs: impl Iterator<Item = f64>) -> f64 {
    let logs: Vec<f64> = logs.collect();
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return largest;
    }
    let sum: f64 = logs.iter().map(|log| libm::exp(log - largest)).sum();
    largest + libm::log(sum / logs.len() as f64)
}
