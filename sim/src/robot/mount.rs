//! Where the camera sits.

use crate::scene::MountSpec;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

impl MountSpec {
    /// `robot_from_camera`: robot frame x forward, y left, z up, origin on the floor under its centre.
    pub fn robot_from_camera(&self) -> Pose {
        Pose::from_parts(
            Translation3::new(0.0, 0.0, self.height),
            looking(self.yaw_deg.to_radians(), self.pitch_deg.to_radians()),
        )
    }
}

/// Rotation from an unrolled camera (x right, y down, z forward) to a z-up frame; yaw turns left from the x axis,
/// pitch up from the horizon.
pub fn looking(yaw: f64, pitch: f64) -> UnitQuaternion<f64> {
    let (sy, cy) = (libm::sin(yaw), libm::cos(yaw));
    let (sp, cp) = (libm::sin(pitch), libm::cos(pitch));
    let forward = Vector3::new(cy * cp, sy * cp, sp);
    let right = Vector3::new(sy, -cy, 0.0);
    let down = forward.cross(&right);
    let axes = Matrix3::from_columns(&[right, down, forward]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_camera_looks_where_it_is_told_with_its_x_axis_level() {
        let mount = MountSpec { height: 1.2, yaw_deg: 90.0, pitch_deg: -30.0 };
        let robot_from_camera = mount.robot_from_camera();
        let forward = robot_from_camera * Vector3::z();
        assert_relative_eq!(forward, Vector3::new(0.0, 0.75_f64.sqrt(), -0.5), epsilon = 1e-12);
        assert_relative_eq!(robot_from_camera * Vector3::x(), Vector3::x(), epsilon = 1e-12);
        let down = robot_from_camera * Vector3::y();
        assert!(down.z < 0.0);
        assert_relative_eq!(robot_from_camera.translation.vector.z, 1.2);
    }
}
