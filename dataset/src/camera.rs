//! The pinhole camera.

use nalgebra::{Point3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// Intrinsics of an ideal pinhole camera, in pixels; pixel `(column, row)` covers
/// `[column, column + 1) x [row, row + 1)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Image width.
    pub width: u32,
    /// Image height.
    pub height: u32,
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y.
    pub fy: f64,
    /// Principal point, x.
    pub cx: f64,
    /// Principal point, y.
    pub cy: f64,
}

impl Camera {
    /// A camera with square pixels and a centred principal point.
    pub fn with_horizontal_fov(width: u32, height: u32, horizontal_fov: f64) -> Self {
        let f = f64::from(width) / 2.0 / libm::tan(horizontal_fov / 2.0);
        Self { width, height, fx: f, fy: f, cx: f64::from(width) / 2.0, cy: f64::from(height) / 2.0 }
    }

    /// The mean of both focal lengths, pixels.
    pub fn focal_length(&self) -> f64 {
        (self.fx + self.fy) / 2.0
    }

    /// The pixel of a point in the camera frame, or `None` behind the camera.
    pub fn project(&self, p_in_camera: &Point3<f64>) -> Option<Vector2<f64>> {
        (p_in_camera.z > 0.0).then(|| {
            Vector2::new(
                self.fx * p_in_camera.x / p_in_camera.z + self.cx,
                self.fy * p_in_camera.y / p_in_camera.z + self.cy,
            )
        })
    }

    /// The ray through a pixel, in the camera frame, scaled to `z = 1`.
    pub fn ray_in_camera(&self, pixel: &Vector2<f64>) -> Vector3<f64> {
        Vector3::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy, 1.0)
    }
}
