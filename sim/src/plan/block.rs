//! Boxes along the world's axes, what furniture is made of.

use nalgebra::Vector3;

/// A box along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Its lowest corner, world frame, metres.
    pub min: Vector3<f64>,
    /// Its highest corner.
    pub max: Vector3<f64>,
}

impl Block {
    /// The box around two.
    pub fn around(self, other: Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }
}
