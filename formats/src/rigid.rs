//! Rigid transforms from matrices.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

/// How far a rotation matrix may be from one.
pub(crate) const RIGID: f64 = 1e-3;

/// The transform of a rotation and a translation; none where the matrix is no rotation.
pub(crate) fn rigid(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Option<Pose> {
    let defect = (rotation.transpose() * rotation - Matrix3::identity()).norm();
    (defect < RIGID && rotation.determinant() > 0.0).then(|| {
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Pose::from_parts(translation.into(), UnitQuaternion::new_normalize(rotation.into_inner()))
    })
}
