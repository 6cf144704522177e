//! Odometry between two robot poses: the motion model of Eq. 3.

use super::{Factor, LinearFactor, dynamic_matrix, dynamic_vector, finite};
use crate::se3_jacobian::right_jacobian_inverse;
use crate::variable::{Key, Values};
use nalgebra::{DVector, Matrix6};
use vantage_dataset::{Pose, se3};

/// `W Log(measured^-1 * from^-1 * to)`.
#[derive(Clone, Debug)]
pub struct BetweenFactor {
    keys: [Key; 2],
    measured: Pose,
    sqrt_information: Matrix6<f64>,
}

impl BetweenFactor {
    /// `measured` is the pose of `to` in the frame of `from`; the information is that of its right
    /// perturbation.
    pub fn new(from: Key, to: Key, measured: Pose, sqrt_information: Matrix6<f64>) -> Self {
        Self { keys: [from, to], measured, sqrt_information }
    }
}

impl Factor for BetweenFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let (from, to) = (values.pose(self.keys[0])?, values.pose(self.keys[1])?);
        let error = se3::log(&self.measured.inv_mul(&from.inv_mul(to)));
        finite(dynamic_vector(&(self.sqrt_information * error)))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let (from, to) = (values.pose(self.keys[0])?, values.pose(self.keys[1])?);
        let from_from_to = from.inv_mul(to);
        let error = se3::log(&self.measured.inv_mul(&from_from_to));
        let d_to = self.sqrt_information * right_jacobian_inverse(&error);
        let d_from = -d_to * se3::adjoint(&from_from_to.inverse());
        LinearFactor {
            residual: dynamic_vector(&(self.sqrt_information * error)),
            jacobians: vec![dynamic_matrix(&d_from), dynamic_matrix(&d_to)],
        }
        .finite()
    }
}
