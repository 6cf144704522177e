//! Coordinates of a variable: the sum of the steps that it was moved by.
//!
//! A pose's steps are right perturbations, and a point's are in the frame of a robot that saw it. So a factor keeps its derivatives when the
//! robot, and all that it sees, move alike, as they do where a loop closes. With coordinates about a fixed base, terms made before such a
//! motion and after it would tell of a heading that no factor tells.

use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector};

/// A variable, and where its value was made.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Its name.
    pub key: Key,
    /// The robot in whose frame a point moves; the world where there is none.
    anchor: Option<Key>,
    /// Where its value is.
    coordinates: Vec<f64>,
}

impl Chart {
    /// At coordinates 0.
    pub fn new(key: Key, dim: usize) -> Self {
        Self { key, anchor: None, coordinates: vec![0.0; dim] }
    }

    /// Has a point move in the frame of one of these, the first time.
    pub fn anchor(&mut self, value: &Value, keys: &[Key]) {
        if matches!(value, Value::Point(_)) && self.anchor.is_none() {
            self.anchor = keys.iter().copied().find(|key| matches!(key, Key::Robot(_)));
        }
    }

    /// The value at other coordinates, where all others are at `values`; `None` of what is not there.
    pub fn advance(&mut self, coordinates: &[f64], values: &Values) -> Option<Value> {
        let moved = coordinates.iter().zip(&self.coordinates).map(|(now, before)| now - before);
        let mut step = DVector::from_iterator(coordinates.len(), moved);
        if let Some(axes) = self.axes(values) {
            step = axes * step;
        }
        self.coordinates.copy_from_slice(coordinates);
        Some(values.get(self.key)?.retract(step.as_slice()))
    }

    /// Its value was taken back to where it was at these coordinates.
    pub fn take_back(&mut self, coordinates: &[f64]) {
        self.coordinates.copy_from_slice(coordinates);
    }

    /// A derivative `[n x dim]` by the right perturbation, or by a point in the world, as one by the coordinates.
    pub fn by_coordinates(&self, derivative: DMatrix<f64>, values: &Values) -> DMatrix<f64> {
        match self.axes(values) {
            Some(axes) => derivative * axes,
            None => derivative,
        }
    }

    /// The axes of a point's coordinates in the world, `[3 x 3]`; `None` where they are the world's, and of all others.
    pub fn axes(&self, values: &Values) -> Option<DMatrix<f64>> {
        let robot = values.pose(self.anchor?)?;
        let rotation = robot.rotation.to_rotation_matrix();
        Some(DMatrix::from_column_slice(3, 3, rotation.matrix().as_slice()))
    }
}
