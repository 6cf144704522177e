//! A pose as seven numbers: `tx, ty, tz, qx, qy, qz, qw`.

use crate::Pose;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};

/// The numbers of a pose, metres and unit quaternion.
pub fn pose_fields(pose: &Pose) -> [f64; 7] {
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w]
}

/// The pose of seven numbers, bit for bit: the quaternion is not normalised, and must be checked.
pub(super) fn from_fields([tx, ty, tz, qx, qy, qz, qw]: [f64; 7]) -> Pose {
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(qw, qx, qy, qz));
    Pose::from_parts(Translation3::new(tx, ty, tz), rotation)
}
