//! Coordinates of a variable about a fixed value.

use crate::se3_jacobian::right_jacobian_inverse;
use crate::variable::{Key, Value};
use nalgebra::{DMatrix, Matrix6};
use vantage_dataset::Tangent;

/// Turn, radians, from which on a pose gets a new chart: the exponential's derivative is singular at a whole turn.
const LARGEST_TURN: f64 = 0.7;

/// A variable as `base` moved by coordinates, which are 0 at the base.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Its name.
    pub key: Key,
    /// Where the coordinates are 0.
    pub base: Value,
}

impl Chart {
    /// The value at some coordinates.
    pub fn at(&self, coordinates: &[f64]) -> Value {
        self.base.retract(coordinates)
    }

    /// A derivative `[n x dim]` by the right perturbation, as one by the coordinates; both are the same but for poses.
    pub fn by_coordinates(&self, derivative: DMatrix<f64>, coordinates: &[f64]) -> DMatrix<f64> {
        if !matches!(self.base, Value::Pose(_)) || coordinates.iter().all(|x| *x == 0.0) {
            return derivative;
        }
        let inverse = right_jacobian_inverse(&Tangent::from_column_slice(coordinates));
        match inverse.try_inverse() {
            Some(right_jacobian) => multiplied(&derivative, &right_jacobian),
            None => derivative,
        }
    }

    /// Whether the coordinates are too far from the base.
    pub fn is_left(&self, coordinates: &[f64]) -> bool {
        matches!(self.base, Value::Pose(_))
            && Tangent::from_column_slice(coordinates).fixed_rows::<3>(0).norm() > LARGEST_TURN
    }
}

fn multiplied(left: &DMatrix<f64>, right: &Matrix6<f64>) -> DMatrix<f64> {
    let product = left * right;
    DMatrix::from_column_slice(left.nrows(), 6, product.as_slice())
}
