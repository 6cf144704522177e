//! A point landmark measured by range and bearing.

use super::{dynamic, linear, rotation, seen, vector2, vector3, wrapped};
use crate::factor::{Factor, LinearFactor};
use crate::variable::{Key, Values};
use nalgebra::{DVector, Matrix2, Vector2};

/// `W (range - r, bearing - b)`, the bearing wrapped; undefined at range 0.
#[derive(Clone, Debug)]
pub struct RangeBearing {
    keys: [Key; 2],
    measured: Vector2<f64>,
    sqrt_information: Matrix2<f64>,
}

impl RangeBearing {
    /// `range`, metres, and `bearing`, radians counter-clockwise from straight ahead.
    pub fn new(robot: Key, landmark: Key, range: f64, bearing: f64, sqrt_information: Matrix2<f64>) -> Self {
        Self { keys: [robot, landmark], measured: Vector2::new(range, bearing), sqrt_information }
    }
}

impl Factor for RangeBearing {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.linearize(values).map(|linear| linear.residual)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let (robot, point) = (vector3(values, self.keys[0])?, vector2(values, self.keys[1])?);
        let (there, by_robot) = seen(&robot, &point);
        let range = there.norm();
        let residual =
            Vector2::new(range - self.measured.x, wrapped(libm::atan2(there.y, there.x) - self.measured.y));
        let squared = range * range;
        let polar = Matrix2::new(there.x / range, there.y / range, -there.y / squared, there.x / squared);
        let w = self.sqrt_information * polar;
        let by_point = w * rotation(robot.z);
        linear(self.sqrt_information * residual, vec![dynamic(&(w * by_robot)), dynamic(&by_point)])
    }
}
