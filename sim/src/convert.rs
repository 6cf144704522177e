//! Between nalgebra in `f64`, which the records use, and glam in `f32`, which the physics engine uses.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::glamx::{Pose3, glam::Quat, glam::Vec3};
use vantage_dataset::Pose;

/// To the engine, rounding.
pub fn vector_to_physics(v: &Vector3<f64>) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// From the engine, exactly.
pub fn vector_from_physics(v: Vec3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z).map(f64::from)
}

/// To the engine, rounding.
pub fn pose_to_physics(pose: &Pose) -> Pose3 {
    let q = pose.rotation.coords.map(|x| x as f32);
    let rotation = Quat::from_xyzw(q.x, q.y, q.z, q.w).normalize();
    Pose3::from_parts(vector_to_physics(&pose.translation.vector), rotation)
}

/// From the engine; the rotation is normalized in `f64`.
pub fn pose_from_physics(pose: &Pose3) -> Pose {
    let [x, y, z, w] = pose.rotation.to_array().map(f64::from);
    Pose::from_parts(
        Translation3::from(vector_from_physics(pose.translation)),
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn there_and_back_is_the_same_pose() {
        let pose = Pose::new(Vector3::new(0.3, -2.0, 1.0), Vector3::new(0.5, 0.2, -1.1));
        let back = pose_from_physics(&pose_to_physics(&pose));
        assert_relative_eq!(back.to_homogeneous(), pose.to_homogeneous(), epsilon = 1e-6);
        let p = Vector3::new(0.1, 0.2, 0.3);
        let rotated = pose_to_physics(&pose).rotation * vector_to_physics(&p);
        assert_relative_eq!(vector_from_physics(rotated), pose.rotation * p, epsilon = 1e-6);
    }
}
