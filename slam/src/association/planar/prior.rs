//! What is known of a planar pose beforehand.

use super::{Motion, dynamic, linear, vector3, wrapped};
use crate::factor::{Factor, LinearFactor};
use crate::variable::{Key, Values};
use nalgebra::{DVector, Matrix3, Vector3};

/// `W (x - x_0)`, the heading wrapped.
#[derive(Clone, Debug)]
pub struct PlanarPrior {
    keys: [Key; 1],
    mean: Motion,
    sqrt_information: Matrix3<f64>,
}

impl PlanarPrior {
    /// About `mean`, in the world.
    pub fn new(key: Key, mean: Motion, sqrt_information: Matrix3<f64>) -> Self {
        Self { keys: [key], mean, sqrt_information }
    }
}

impl Factor for PlanarPrior {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.linearize(values).map(|linear| linear.residual)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let off = vector3(values, self.keys[0])? - self.mean.vector();
        let residual = Vector3::new(off.x, off.y, wrapped(off.z));
        linear(self.sqrt_information * residual, vec![dynamic(&self.sqrt_information)])
    }

    fn is_anchor(&self) -> bool {
        true
    }
}
