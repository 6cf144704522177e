//! From a model's frame to the image and to the light, for both renderers.

use super::{Light, Placement, Shot};
use nalgebra::Matrix3x4;

/// `(column * depth, row * depth, depth)` of a homogeneous point of the model; pixels and metres.
pub(super) fn pixels_from_model(shot: &Shot, placement: &Placement) -> Matrix3x4<f64> {
    let camera = &shot.camera;
    let camera_from_model = shot.world_from_camera.inv_mul(&placement.world_from_model).to_homogeneous();
    let (x, y, z) = (camera_from_model.row(0), camera_from_model.row(1), camera_from_model.row(2));
    Matrix3x4::from_rows(&[x * camera.fx + z * camera.cx, y * camera.fy + z * camera.cy, z.into()])
}

/// The direction towards the light in the model's frame.
pub(super) fn light_in_model(light: &Light, placement: &Placement) -> [f32; 3] {
    let direction = placement.world_from_model.rotation.inverse() * light.direction;
    [direction.x as f32, direction.y as f32, direction.z as f32]
}
