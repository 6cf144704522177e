//! Odometry whose bias is a variable: the motion model of Eq. 3 with an error that all steps share.

use super::{BetweenFactor, Factor, LinearFactor, finite};
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector, Matrix6, Matrix6x2};
use vantage_dataset::Pose;

/// `W (Log(measured^-1 * from^-1 * to) + B b)`, since `measured = from^-1 * to * Exp(B b + white noise)`.
#[derive(Clone, Debug)]
pub struct BiasedBetweenFactor {
    keys: [Key; 3],
    between: BetweenFactor,
    /// `W B`.
    response: DMatrix<f64>,
}

impl BiasedBetweenFactor {
    /// `measured` is the pose of `to` in the frame of `from`; `sqrt_information` is that of the white noise alone, and
    /// `response` is `B` for the numbers of [`Key::OdometryBias`].
    pub fn new(
        from: Key,
        to: Key,
        measured: Pose,
        sqrt_information: Matrix6<f64>,
        response: &Matrix6x2<f64>,
    ) -> Self {
        let whitened = sqrt_information * response;
        Self {
            keys: [from, to, Key::OdometryBias],
            between: BetweenFactor::new(from, to, measured, sqrt_information),
            response: DMatrix::from_column_slice(6, 2, whitened.as_slice()),
        }
    }

    fn bias<'v>(&self, values: &'v Values) -> Option<&'v DVector<f64>> {
        values.vector(Key::OdometryBias).filter(|bias| bias.len() == self.response.ncols())
    }
}

impl Factor for BiasedBetweenFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        finite(self.between.residual(values)? + &self.response * self.bias(values)?)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let LinearFactor { mut residual, mut jacobians } = self.between.linearize(values)?;
        residual += &self.response * self.bias(values)?;
        jacobians.push(self.response.clone());
        LinearFactor { residual, jacobians }.finite()
    }
}
