//! Lens distortion.

use nalgebra::Vector2;
use vantage_dataset::camera::Camera;

/// Rounds of the fixed-point iteration that undoes a distortion.
const ROUNDS: usize = 100;
/// How well it must have been undone, on the plane `z = 1`.
const TOLERANCE: f64 = 1e-9;

/// Distortion by Brown and Conrady, in OpenCV's order; all zero for an ideal lens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Radial, of the 2nd power.
    pub k1: f64,
    /// Radial, of the 4th power.
    pub k2: f64,
    /// Tangential.
    pub p1: f64,
    /// Tangential.
    pub p2: f64,
    /// Radial, of the 6th power.
    pub k3: f64,
}

impl Lens {
    /// Where a lens puts a point of the plane `z = 1`.
    pub fn distort(&self, ideal: &Vector2<f64>) -> Vector2<f64> {
        ideal * self.radial(ideal) + self.tangential(ideal)
    }

    /// The point of the plane `z = 1` that a lens puts at `distorted`; none where no such point is found.
    pub fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut ideal = *distorted;
        for _ in 0..ROUNDS {
            ideal = (distorted - self.tangential(&ideal)) / self.radial(&ideal);
        }
        ((self.distort(&ideal) - distorted).norm() < TOLERANCE).then_some(ideal)
    }

    /// Where an ideal lens would have put what is seen at a pixel.
    pub fn undistort_pixel(&self, camera: &Camera, pixel: &Vector2<f64>) -> Option<Vector2<f64>> {
        let ideal = self.undistort(&camera.ray_in_camera(pixel).xy())?;
        Some(Vector2::new(camera.fx * ideal.x + camera.cx, camera.fy * ideal.y + camera.cy))
    }

    fn radial(&self, ideal: &Vector2<f64>) -> f64 {
        let r2 = ideal.norm_squared();
        1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
    }

    fn tangential(&self, ideal: &Vector2<f64>) -> Vector2<f64> {
        let (x, y, r2) = (ideal.x, ideal.y, ideal.norm_squared());
        Vector2::new(
            2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x),
            self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undistorting_inverts_distorting() {
        let lens = Lens { k1: 0.382, k2: 0.106, p1: 0.00086, p2: -0.00143, k3: 0.01 };
        for ideal in [Vector2::new(0.0, 0.0), Vector2::new(0.6, -0.35), Vector2::new(-0.4, 0.2)] {
            let distorted = lens.distort(&ideal);
            assert!((lens.undistort(&distorted).unwrap() - ideal).norm() < 1e-8);
        }
        assert!(
            (lens.distort(&Vector2::new(0.6, 0.0)).x
                - 0.6 * (1.0 + 0.13752 + 0.0137376 + 0.00046656)
                - -0.00143 * 3.0 * 0.36)
                .abs()
                < 1e-12
        );
    }

    #[test]
    fn a_point_that_the_lens_cannot_reach_is_none() {
        let barrel = Lens { k1: -0.5, ..Lens::default() };
        assert_eq!(barrel.undistort(&Vector2::new(3.0, 0.0)), None);
    }
}
