//! Rigid transforms from matrices.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

/// How far a rotation matrix may be from one.
pub(crate) const RIGID: f64 = 1e-3;

/// How far a matrix may be from the rotation that is meant by it.
const NEARLY: f64 = 0.02;

/// The transform of the rotation nearest to a matrix that is nearly one, as annotations have them: `U V^T` of its singular value
/// decomposition. None where the matrix is farther off, or mirrors.
pub(crate) fn nearly_rigid(matrix: Matrix3<f64>, translation: Vector3<f64>) -> Option<Pose> {
    let defect = (matrix.transpose() * matrix - Matrix3::identity()).norm();
    if defect >= NEARLY || matrix.determinant() <= 0.0 || !defect.is_finite() {
        return None;
    }
    let svd = matrix.svd(true, true);
    rigid(svd.u? * svd.v_t?, translation)
}

/// The transform of a rotation and a translation; none where the matrix is no rotation.
pub(crate) fn rigid(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Option<Pose> {
    let defect = (rotation.transpose() * rotation - Matrix3::identity()).norm();
    (defect < RIGID && rotation.determinant() > 0.0).then(|| {
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Pose::from_parts(translation.into(), UnitQuaternion::new_normalize(rotation.into_inner()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_that_is_nearly_a_rotation_means_the_nearest_one() {
        let turn = Rotation3::from_euler_angles(0.3, -1.0, 2.0);
        let pose = nearly_rigid(turn.matrix() * 1.003, Vector3::x()).unwrap();
        assert!(pose.rotation.to_rotation_matrix().angle_to(&turn) < 1e-7);
        assert!(rigid(turn.matrix() * 1.003, Vector3::x()).is_none());
        for wrong in [turn.matrix() * 1.1, -turn.matrix(), turn.matrix() * f64::NAN] {
            assert!(nearly_rigid(wrong, Vector3::x()).is_none());
        }
    }
}
