//! The robot of recordings that know a camera alone.

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

/// Where the sine of the angle between the optical axis and the vertical is no more than this, one degree, the axis tells no heading.
const HEADS: f64 = 0.0175;

/// The camera on a robot that stands at the camera and is level at the first step. There the robot's z axis is the world's, and its x axis
/// heads where the camera looks. If that is straight down, the upper edge of the image is ahead; if straight up, the lower edge.
///
/// Estimators take the first pose for level, as a robot knows gravity. Later poses tilt with the camera.
pub(crate) fn robot_from_camera(world_from_first_camera: &Pose) -> Pose {
    let to_world = |axis| world_from_first_camera.rotation * axis;
    let sight: Vector3<f64> = to_world(Vector3::z());
    let ahead = if sight.xy().norm() > HEADS { sight } else { to_world(Vector3::y()) * sight.z.signum() };
    let x = Vector3::new(ahead.x, ahead.y, 0.0).normalize();
    let level = Matrix3::from_columns(&[x, Vector3::z().cross(&x), Vector3::z()]);
    let level = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(level));
    Pose::from_parts(Translation3::identity(), level.inverse() * world_from_first_camera.rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// A camera at the origin that looks towards `target`, `up` in its image.
    fn camera(target: [f64; 3], up: Vector3<f64>) -> Pose {
        Pose::face_towards(&Point3::origin(), &Point3::from(target), &-up)
    }

    #[test]
    fn the_robot_is_level_and_heads_where_the_camera_looks() {
        for (target, up, ahead) in [
            ([1.0, 0.0, 0.0], Vector3::z(), Vector3::x()),
            ([0.0, 2.0, -5.0], Vector3::z(), Vector3::y()),
            ([0.0, -2.0, -1.0], Vector3::new(0.7, 0.0, 0.7), -Vector3::y()),
            ([0.0, 0.0, -1.0], -Vector3::x(), -Vector3::x()),
            ([0.0, 0.0, 1.0], Vector3::y(), -Vector3::y()),
        ] {
            let world_from_camera = camera(target, up);
            let robot = world_from_camera * robot_from_camera(&world_from_camera).inverse();
            assert!((robot.rotation * Vector3::z() - Vector3::z()).norm() < 1e-12, "{target:?}");
            assert!((robot.rotation * Vector3::x() - ahead).norm() < 1e-12, "{target:?}");
            assert_eq!(robot.translation, world_from_camera.translation);
        }
    }
}
