//! The mean of poses that are near each other.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

/// Mean position, and the chordal mean of rotations (Markley et al. 2007, to first order): quaternions with the sign of the first, summed.
/// The identity of none.
pub(crate) fn mean_pose(poses: &[Pose]) -> Pose {
    let Some(first) = poses.first() else { return Pose::identity() };
    let position: Vector3<f64> = poses.iter().map(|pose| pose.translation.vector).sum();
    let reference = first.rotation.coords;
    let sum = poses.iter().map(|pose| {
        let coords = pose.rotation.coords;
        if coords.dot(&reference) < 0.0 { -coords } else { coords }
    });
    let rotation = UnitQuaternion::from_quaternion(Quaternion::from(sum.sum::<nalgebra::Vector4<f64>>()));
    Pose::from_parts(Translation3::from(position / poses.len() as f64), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_on_both_sides_cancel_whatever_the_sign_of_a_quaternion() {
        let middle = Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -2.0, 1.0));
        let offset = |sign: f64| middle * Pose::new(Vector3::x() * 0.1 * sign, Vector3::y() * 0.05 * sign);
        let mut other = offset(-1.0);
        other.rotation = UnitQuaternion::new_unchecked(-other.rotation.into_inner());
        let mean = mean_pose(&[offset(1.0), other]);
        assert!((mean.translation.vector - middle.translation.vector).norm() < 1e-12);
        assert!(mean.rotation.angle_to(&middle.rotation) < 1e-7);
        assert_eq!(mean_pose(&[]), Pose::identity());
    }
}
