//! The semantic measurements Z^s of an object whose place is known: which views are used, and its size.

use crate::estimate::Dropped;
use crate::observation_model::{ModelError, ObservationModel};
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::{Key, Values};
use nalgebra::{DVector, Vector3};
use vantage_dataset::{Crop, Pose, Viewpoint};

/// An object with semantic views.
#[derive(Clone, Debug)]
pub struct SemanticObject {
    /// Its track.
    pub track: usize,
    /// Its diameter, metres: an estimate that is held.
    pub size: f64,
    /// Its usable views, by step.
    pub views: Vec<SemanticView>,
}

/// One usable crop.
#[derive(Clone, Debug)]
pub struct SemanticView {
    /// Where and when.
    pub sighting: Sighting,
    /// `m(z)`, `[M]`.
    pub measurement: DVector<f64>,
    /// `x_rel` if the object stood upright at yaw 0.
    pub viewpoint: Viewpoint,
}

/// An object's diameter, metres: the median over its views of box side times depth, by the spec's ratio of diameter to
/// side. `None` where it is behind all cameras.
pub fn object_size(
    problem: &Problem<'_>,
    values: &Values,
    track: usize,
    sightings: &[Sighting],
) -> Option<f64> {
    let position = values.get(Key::Object(track))?.position()?;
    let mut sizes: Vec<f64> = sightings
        .iter()
        .filter_map(|sighting| {
            let world_from_camera = problem.world_from_camera(values, sighting.step)?;
            let depth = world_from_camera.inverse_transform_point(&position.into()).z;
            (depth > 0.0).then_some(sighting.angular_size * depth)
        })
        .collect();
    sizes.sort_by(f64::total_cmp);
    let middle = sizes.len() / 2;
    let side = if sizes.len() % 2 == 1 {
        *sizes.get(middle)?
    } else {
        (sizes.get(middle)? + sizes[middle - 1]) / 2.0
    };
    Some(side * problem.spec.size_over_box_side).filter(|size| size.is_finite() && *size > 0.0)
}

/// Measures the crops of one object that can be used, and counts the others.
pub fn semantic_object(
    problem: &Problem<'_>,
    model: &dyn ObservationModel,
    values: &Values,
    track: usize,
    sightings: &[Sighting],
    dropped: &mut Dropped,
) -> Result<Option<SemanticObject>, ModelError> {
    let position = values.get(Key::Object(track)).and_then(|value| value.position());
    let (Some(position), Some(size)) = (position, object_size(problem, values, track, sightings)) else {
        dropped.undefined_viewpoint += sightings.len();
        return Ok(None);
    };
    let upright = Pose::translation(position.x, position.y, position.z);
    let mut views: Vec<SemanticView> = Vec::new();
    for &sighting in sightings {
        let viewpoint = problem
            .world_from_camera(values, sighting.step)
            .and_then(|world_from_camera| Viewpoint::new(&upright.inv_mul(&world_from_camera), size));
        let Some(viewpoint) = viewpoint else {
            dropped.undefined_viewpoint += 1;
            continue;
        };
        let separation = problem.spec.minimum_view_separation;
        // Only of the view before: the same direction again, a lap later, is what closes the loop.
        let repeats =
            |used: &SemanticView| angle(&used.viewpoint.direction, &viewpoint.direction) < separation;
        if views.last().is_some_and(repeats) {
            dropped.redundant_viewpoint += 1;
            continue;
        }
        let crop = &problem.observations.detections[sighting.detection].masked_crop;
        match measure(model, crop, &viewpoint)? {
            Some(measurement) => views.push(SemanticView { sighting, measurement, viewpoint }),
            None => dropped.non_finite += 1,
        }
    }
    Ok((!views.is_empty()).then_some(SemanticObject { track, size, views }))
}

/// `m(z)` if the model answers this crop with finite numbers throughout.
fn measure(
    model: &dyn ObservationModel,
    crop: &Crop,
    viewpoint: &Viewpoint,
) -> Result<Option<DVector<f64>>, ModelError> {
    let (m, d) = (model.measurement_dim(), model.latent_dim());
    let Some(measurement) = unless_non_finite(model.measure(crop))? else { return Ok(None) };
    expect_length("measurement", measurement.len(), m)?;
    let Some(posterior) = unless_non_finite(model.encode(crop, viewpoint))? else { return Ok(None) };
    expect_length("encoder's mean", posterior.mean.len(), d)?;
    expect_length("encoder's variance", posterior.variance.len(), d)?;
    if !posterior.is_valid(d) || !measurement.iter().all(|x| x.is_finite()) {
        return Ok(None);
    }
    let near = unless_non_finite(model.linearize(&posterior.mean, &viewpoint.conditioning()))?;
    let Some(near) = near else { return Ok(None) };
    expect_length("prediction", near.mean.len(), m)?;
    expect_length("derivative to the latent (columns)", near.d_latent.ncols(), d)?;
    Ok(near.is_valid(m, d).then_some(measurement))
}

/// A model's answer, or `None` where it says that it is not finite.
pub(crate) fn unless_non_finite<T>(answer: Result<T, ModelError>) -> Result<Option<T>, ModelError> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(ModelError::NonFinite { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

fn expect_length(what: &'static str, got: usize, expected: usize) -> Result<(), ModelError> {
    if got == expected { Ok(()) } else { Err(ModelError::Shape { what, got, expected }) }
}

fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}
