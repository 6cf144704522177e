//! Which way is up.

use super::arrangement::Arrangement;
use super::files::Frame;
use super::places::GT;
use crate::import::ImportError;
use nalgebra::{Translation3, Unit, UnitQuaternion, Vector3};
use std::path::Path;
use vantage_dataset::Pose;

/// The cosine that two axes which agree must have.
const AGREE: f64 = 0.94;
/// The cosine to the vertical of the z axis of an object that stands on its base.
const STANDS: f64 = 0.87;

/// An arrangement's place in a world with z up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upright {
    pub(super) world_from_arrangement: Pose,
}

/// The mean z axis of the models that most others agree with, if these are more than half; otherwise the z axis of a world that is given,
/// which stays as it is where the two agree.
pub(super) fn upright(
    scene: &Path,
    frames: &[Frame],
    arrangement: &Arrangement<'_>,
) -> Result<Upright, ImportError> {
    let axes: Vec<Vector3<f64>> =
        arrangement.placements.values().map(|pose| pose.rotation * Vector3::z()).collect();
    let agreeing = |axis: &Vector3<f64>| -> Vec<Vector3<f64>> {
        axes.iter().filter(|other| axis.dot(other) > AGREE).copied().collect()
    };
    let most =
        axes.iter().map(agreeing).reduce(|a, b| if b.len() > a.len() { b } else { a }).unwrap_or_default();
    let of_models = (2 * most.len() > axes.len()).then(|| most.iter().sum::<Vector3<f64>>().normalize());
    let keeps_world = arrangement.is_given && of_models.is_none_or(|up| up.z > AGREE);
    if keeps_world {
        return Ok(Upright { world_from_arrangement: Pose::identity() });
    }
    let Some(up) = of_models else {
        let image = arrangement.frames.first().or(frames.first()).map_or(0, |frame| frame.image);
        let field = format!("cam_R_m2c, from image {image}");
        let got = "models whose z axes point all ways, and no cam_R_w2c of every image";
        let remedy = "give the cameras' poses in a world whose z axis is up";
        return Err(ImportError::invalid(&scene.join(GT), field, got, "most models with z up", remedy));
    };
    let turned = UnitQuaternion::rotation_between_axis(&Unit::new_normalize(up), &Vector3::z_axis())
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let middle: Vector3<f64> = arrangement.placements.values().map(|pose| pose.translation.vector).sum();
    let origin = turned * (middle / arrangement.placements.len().max(1) as f64);
    Ok(Upright { world_from_arrangement: Pose::from_parts(Translation3::from(-origin), turned) })
}

/// Whether an object stands on its base, or nearly.
pub(super) fn stands(world_from_object: &Pose) -> bool {
    (world_from_object.rotation * Vector3::z()).z > STANDS
}
