//! A view of an object that is linear in coordinates about fixed poses: what a network costs is left out.

use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Pose, se3};
use vantage_slam::Key;
use vantage_slam::factor::{Factor, LinearFactor};
use vantage_slam::se3_jacobian::right_jacobian_inverse;
use vantage_slam::variable::Values;

/// `A_x Log(x_0^-1 x) + A_o Log(o_0^-1 o) + A_e e + c`.
pub struct ViewFactor {
    /// Of robot, object and latent.
    pub keys: [Key; 3],
    /// `x_0` and `o_0`.
    pub bases: [Pose; 2],
    /// `A_x`, `A_o`, `A_e`, `[M x 6]`, `[M x 6]`, `[M x D]`.
    pub jacobians: [DMatrix<f64>; 3],
    /// `c`, `[M]`.
    pub constant: DVector<f64>,
}

impl Factor for ViewFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let mut residual = self.constant.clone();
        for ((base, key), jacobian) in self.bases.iter().zip(&self.keys).zip(&self.jacobians) {
            let coordinates = se3::log(&base.inv_mul(values.pose(*key)?));
            residual.gemv(1.0, jacobian, &coordinates, 1.0);
        }
        residual.gemv(1.0, &self.jacobians[2], values.vector(self.keys[2])?, 1.0);
        Some(residual)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let mut jacobians = self.jacobians.to_vec();
        for ((base, key), jacobian) in self.bases.iter().zip(&self.keys).zip(&mut jacobians) {
            let coordinates = se3::log(&base.inv_mul(values.pose(*key)?));
            let turned = &*jacobian * right_jacobian_inverse(&coordinates);
            jacobian.copy_from(&turned);
        }
        Some(LinearFactor { residual: self.residual(values)?, jacobians })
    }
}
