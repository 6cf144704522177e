//! The allocentric viewpoint `x_rel` of Eq. 10: from where, and how turned, a camera sees an object.

use crate::se3::{Pose, hat};
use nalgebra::{RowVector3, RowVector6, SMatrix, Vector3};

/// The numbers a network is conditioned on: see [`Viewpoint::conditioning`].
pub const CONDITIONING: usize = 2 * HARMONICS + 4;
/// Azimuth harmonics in the conditioning, `m = 1..=HARMONICS`.
pub const HARMONICS: usize = 5;

/// The viewpoint of a crop that is centred on the object.
///
/// Such a crop hides where in the image the object was, so that its look depends on the direction from the
/// object to the camera, the roll about the viewing ray, and the distance in object sizes; not on the
/// camera's egocentric rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Unit vector from the object's centre to the camera, object frame.
    pub direction: Vector3<f64>,
    /// Roll about the viewing ray, radians: the angle, seen in the image and clockwise, from "up" to the projection of
    /// the object's z axis. 0 for an upright object and an unrolled camera.
    pub roll: f64,
    /// Natural logarithm of (distance from the object's centre / `object size`).
    pub log_distance: f64,
}

impl Viewpoint {
    /// The viewpoint of a camera at `object_from_camera` (translation in metres) of an object of
    /// `object_size` metres (diameter of its bounding sphere), or `None` where the camera is at the object's
    /// centre or on its z axis, or the object is behind the camera.
    pub fn new(object_from_camera: &Pose, object_size: f64) -> Option<Self> {
        let p = object_from_camera.translation.vector;
        let distance = p.norm();
        let horizontal = libm::hypot(p.x, p.y);
        let normal = axis_plane_normal(object_from_camera);
        let center_in_camera = object_from_camera.inverse().translation.vector;
        let defined = object_size > 0.0
            && horizontal > 1e-6 * distance
            && center_in_camera.z > 0.0
            && libm::hypot(normal.x, normal.y) > 1e-9 * distance;
        defined.then(|| Self {
            direction: p / distance,
            roll: libm::atan2(-normal.y, -normal.x),
            log_distance: libm::log(distance / object_size),
        })
    }

    /// Azimuth of the camera about the object's z axis, radians in `(-pi, pi]`.
    pub fn azimuth(&self) -> f64 {
        libm::atan2(self.direction.y, self.direction.x)
    }

    /// Elevation of the camera above the object's xy plane, radians.
    pub fn elevation(&self) -> f64 {
        libm::asin(self.direction.z.clamp(-1.0, 1.0))
    }

    /// The same view of the object turned by `-angle` about its z axis: azimuth grows by `angle`.
    pub fn turned(&self, angle: f64) -> Self {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        let d = self.direction;
        Self { direction: Vector3::new(c * d.x - s * d.y, s * d.x + c * d.y, d.z), ..*self }
    }

    /// The numbers a network sees: `[cos ma, sin ma for m = 1..=5, sin elevation, cos roll, sin roll, log distance]`.
    pub fn conditioning(&self) -> [f64; CONDITIONING] {
        let azimuth = self.azimuth();
        let mut x = [0.0; CONDITIONING];
        for m in 1..=HARMONICS {
            x[2 * m - 2] = libm::cos(m as f64 * azimuth);
            x[2 * m - 1] = libm::sin(m as f64 * azimuth);
        }
        x[2 * HARMONICS..].copy_from_slice(&[
            self.direction.z,
            libm::cos(self.roll),
            libm::sin(self.roll),
            self.log_distance,
        ]);
        x
    }

    /// `d x / d delta` of the [conditioning](Self::conditioning) `x` of [`Viewpoint::new`], for
    /// `object_from_camera * Exp(delta)`, delta rotation first.
    pub fn jacobian(object_from_camera: &Pose, object_size: f64) -> Option<SMatrix<f64, CONDITIONING, 6>> {
        let x = Viewpoint::new(object_from_camera, object_size)?.conditioning();
        let rotation = object_from_camera.rotation.to_rotation_matrix().into_inner();
        let p = object_from_camera.translation.vector;
        let distance = p.norm();
        let unit = p / distance;

        let horizontal_squared = p.x * p.x + p.y * p.y;
        let mut azimuth = RowVector6::zeros();
        azimuth
            .fixed_columns_mut::<3>(3)
            .copy_from(&(RowVector3::new(-p.y, p.x, 0.0) * rotation / horizontal_squared));
        let mut sin_elevation = RowVector6::zeros();
        sin_elevation
            .fixed_columns_mut::<3>(3)
            .copy_from(&((RowVector3::new(0.0, 0.0, 1.0) - unit.transpose() * unit.z) * rotation / distance));
        let mut log_distance = RowVector6::zeros();
        log_distance.fixed_columns_mut::<3>(3).copy_from(&(unit.transpose() * rotation / distance));

        let center = -(rotation.transpose() * p);
        let axis = rotation.transpose() * Vector3::z();
        let n = axis.cross(&center);
        let mut normal = SMatrix::<f64, 3, 6>::zeros();
        normal.fixed_columns_mut::<3>(0).copy_from(&(hat(&axis) * hat(&center) - hat(&center) * hat(&axis)));
        normal.fixed_columns_mut::<3>(3).copy_from(&-hat(&axis));
        let roll = (normal.row(1) * n.x - normal.row(0) * n.y) / (n.x * n.x + n.y * n.y);

        let mut jacobian = SMatrix::<f64, CONDITIONING, 6>::zeros();
        for m in 1..=HARMONICS {
            let order = m as f64;
            jacobian.set_row(2 * m - 2, &(azimuth * (-order * x[2 * m - 1])));
            jacobian.set_row(2 * m - 1, &(azimuth * (order * x[2 * m - 2])));
        }
        let tail = 2 * HARMONICS;
        jacobian.set_row(tail, &sin_elevation);
        jacobian.set_row(tail + 1, &(roll * -x[tail + 2]));
        jacobian.set_row(tail + 2, &(roll * x[tail + 1]));
        jacobian.set_row(tail + 3, &log_distance);
        Some(jacobian)
    }
}

/// Normal, camera frame, of the plane through the camera that holds the object's z axis.
fn axis_plane_normal(object_from_camera: &Pose) -> Vector3<f64> {
    let camera_from_object = object_from_camera.inverse();
    let axis = camera_from_object.rotation * Vector3::z();
    axis.cross(&camera_from_object.translation.vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::se3;
    use approx::assert_relative_eq;
    use nalgebra::{Point3, Vector6};
    use std::f64::consts::PI;

    /// A camera at `azimuth`, `elevation`, `distance` that looks past the origin by `off_axis`, rolled.
    fn object_from_camera(azimuth: f64, elevation: f64, distance: f64, off_axis: f64, roll: f64) -> Pose {
        let eye = Point3::new(
            distance * elevation.cos() * azimuth.cos(),
            distance * elevation.cos() * azimuth.sin(),
            distance * elevation.sin(),
        );
        let looking = Pose::face_towards(&eye, &Point3::origin(), &-Vector3::z());
        looking * Pose::rotation(Vector3::y() * off_axis) * Pose::rotation(Vector3::z() * roll)
    }

    #[test]
    fn a_camera_in_front_sees_azimuth_elevation_and_no_roll() {
        let view = Viewpoint::new(&object_from_camera(0.7, 0.3, 2.0, 0.0, 0.0), 0.5).unwrap();
        assert_relative_eq!(view.azimuth(), 0.7, epsilon = 1e-12);
        assert_relative_eq!(view.elevation(), 0.3, epsilon = 1e-12);
        assert_relative_eq!(view.roll, 0.0, epsilon = 1e-12);
        assert_relative_eq!(view.log_distance, 4f64.ln(), epsilon = 1e-12);
    }

    #[test]
    fn a_camera_rolled_clockwise_sees_the_object_turn_counter_clockwise() {
        let view = Viewpoint::new(&object_from_camera(0.7, 0.0, 2.0, 0.0, 0.2), 0.5).unwrap();
        assert_relative_eq!(view.roll, -0.2, epsilon = 1e-12);
    }

    #[test]
    fn turning_adds_to_the_azimuth() {
        let view = Viewpoint::new(&object_from_camera(0.7, 0.3, 2.0, 0.2, 0.1), 0.5).unwrap();
        assert_relative_eq!(view.turned(1.1).azimuth(), 1.8, epsilon = 1e-12);
    }

    #[test]
    fn undefined_viewpoints_are_none() {
        assert!(Viewpoint::new(&Pose::identity(), 1.0).is_none());
        assert!(Viewpoint::new(&object_from_camera(0.0, 0.0, 2.0, PI, 0.0), 0.5).is_none());
        assert!(Viewpoint::new(&Pose::translation(0.0, 0.0, 2.0), 1.0).is_none());
    }

    #[test]
    fn jacobian_matches_central_differences() {
        for (azimuth, elevation, off_axis, roll) in
            [(0.3, 0.2, 0.0, 0.0), (-2.9, 0.9, 0.3, 0.4), (3.1, -0.5, -0.4, -2.0), (1.5, 1.2, 0.2, 3.1)]
        {
            let pose = object_from_camera(azimuth, elevation, 1.7, off_axis, roll);
            let analytic = Viewpoint::jacobian(&pose, 0.3).unwrap();
            for column in 0..6 {
                let mut step = Vector6::zeros();
                step[column] = 1e-6;
                let plus = Viewpoint::new(&(pose * se3::exp(&step)), 0.3).unwrap().conditioning();
                let minus = Viewpoint::new(&(pose * se3::exp(&-step)), 0.3).unwrap().conditioning();
                for row in 0..CONDITIONING {
                    assert_relative_eq!(
                        analytic[(row, column)],
                        (plus[row] - minus[row]) / 2e-6,
                        epsilon = 1e-6
                    );
                }
            }
        }
    }
}
