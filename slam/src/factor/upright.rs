//! The prior P(o) of an object that stands upright: its tilt is small and its yaw is free, unless its frame is to be held.

use super::{Factor, LinearFactor, finite};
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector, RowVector3, UnitQuaternion, Vector3};
use vantage_dataset::se3::{hat, so3_left_jacobian_inverse, so3_log};

/// Residual of 3 numbers: x and y of the world's up in the object frame over the tilt's sigma, and the yaw.
#[derive(Clone, Debug)]
pub struct UprightFactor {
    keys: [Key; 1],
    tilt_sigma: f64,
    yaw_sigma: f64,
    reference: UnitQuaternion<f64>,
}

impl UprightFactor {
    /// Standard deviation of a free yaw about the reference, radians. Too wide to be felt (a semantic view of even
    /// 60 degrees outweighs it a million times); it keeps the normal equations definite where no view tells yaw.
    pub const FREE_YAW: f64 = 1e3;

    /// An upright prior of `tilt_sigma` radians about either horizontal axis, and of `yaw_sigma` about the vertical one; `reference` is
    /// the orientation the yaw is measured from.
    pub fn new(key: Key, [tilt_sigma, yaw_sigma]: [f64; 2], reference: UnitQuaternion<f64>) -> Self {
        Self { keys: [key], tilt_sigma, yaw_sigma, reference }
    }

    fn whiten(&self, up_in_object: &Vector3<f64>, turn: &Vector3<f64>) -> DVector<f64> {
        DVector::from_vec(vec![
            up_in_object.x / self.tilt_sigma,
            up_in_object.y / self.tilt_sigma,
            turn.z / self.yaw_sigma,
        ])
    }
}

impl Factor for UprightFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let rotation = values.pose(self.keys[0])?.rotation;
        let up_in_object = rotation.inverse() * Vector3::z();
        finite(self.whiten(&up_in_object, &so3_log(&(self.reference.inverse() * rotation))))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let rotation = values.pose(self.keys[0])?.rotation;
        let up_in_object = rotation.inverse() * Vector3::z();
        let turn = so3_log(&(self.reference.inverse() * rotation));
        let d_up = hat(&up_in_object) / self.tilt_sigma;
        let d_yaw: RowVector3<f64> = so3_left_jacobian_inverse(&-turn).row(2) / self.yaw_sigma;
        let mut jacobian = DMatrix::zeros(3, 6);
        jacobian.view_mut((0, 0), (2, 3)).copy_from(&d_up.rows(0, 2));
        jacobian.view_mut((2, 0), (1, 3)).copy_from(&d_yaw);
        LinearFactor { residual: self.whiten(&up_in_object, &turn), jacobians: vec![jacobian] }.finite()
    }
}
