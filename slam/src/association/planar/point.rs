//! A point landmark measured in the robot's frame.

use super::{dynamic, linear, rotation, seen, vector2, vector3};
use crate::factor::{Factor, LinearFactor};
use crate::variable::{Key, Values};
use nalgebra::{DVector, Matrix2, Vector2};

/// `W (R^T (l - t) - z)`.
#[derive(Clone, Debug)]
pub struct PlanarPoint {
    keys: [Key; 2],
    measured: Vector2<f64>,
    sqrt_information: Matrix2<f64>,
}

impl PlanarPoint {
    /// `measured` is the landmark in the robot's frame, metres.
    pub fn new(robot: Key, landmark: Key, measured: Vector2<f64>, sqrt_information: Matrix2<f64>) -> Self {
        Self { keys: [robot, landmark], measured, sqrt_information }
    }
}

impl Factor for PlanarPoint {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.linearize(values).map(|linear| linear.residual)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let (robot, point) = (vector3(values, self.keys[0])?, vector2(values, self.keys[1])?);
        let (there, by_robot) = seen(&robot, &point);
        let w = &self.sqrt_information;
        let by_point = w * rotation(robot.z);
        linear(w * (there - self.measured), vec![dynamic(&(w * by_robot)), dynamic(&by_point)])
    }
}
