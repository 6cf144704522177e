//! Where in an image an object may be.

use nalgebra::{Point3, Vector2, Vector3};
use vantage_dataset::{BoundingBox, Camera, Pose};

/// Box, pixels, around the projection of an object's own bounding box (half extents in metres): at least as large
/// as its silhouette. Corners behind the camera are left out.
pub fn projected(camera: &Camera, camera_from_object: &Pose, half_extents: &Vector3<f64>) -> BoundingBox {
    let corners = (0..8).map(|i| {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        Point3::from(half_extents.component_mul(&Vector3::new(sign(0), sign(1), sign(2))))
    });
    let mut bounds =
        BoundingBox { min: Vector2::repeat(f64::INFINITY), max: Vector2::repeat(f64::NEG_INFINITY) };
    for pixel in corners.filter_map(|corner| camera.project(&(camera_from_object * corner))) {
        bounds.min = bounds.min.inf(&pixel);
        bounds.max = bounds.max.sup(&pixel);
    }
    bounds
}
