//! One planar pose measured from another: odometry, or a loop.

use super::{Motion, dynamic, linear, rotation, seen, vector3, wrapped};
use crate::factor::{Factor, LinearFactor};
use crate::variable::{Key, Values};
use nalgebra::{DVector, Matrix3, Vector3};

/// `W` times the pose of `to` in the frame where it was measured to be, the heading wrapped.
#[derive(Clone, Debug)]
pub struct PlanarBetween {
    keys: [Key; 2],
    measured: Motion,
    sqrt_information: Matrix3<f64>,
}

impl PlanarBetween {
    /// `measured` is the pose of `to` in the frame of `from`.
    pub fn new(from: Key, to: Key, measured: Motion, sqrt_information: Matrix3<f64>) -> Self {
        Self { keys: [from, to], measured, sqrt_information }
    }
}

impl Factor for PlanarBetween {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.linearize(values).map(|linear| linear.residual)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let (from, to) = (vector3(values, self.keys[0])?, vector3(values, self.keys[1])?);
        let (there, by_from) = seen(&from, &to.xy());
        let turn = rotation(self.measured.heading);
        let off = turn * (there - self.measured.vector().xy());
        let residual = Vector3::new(off.x, off.y, wrapped(to.z - from.z - self.measured.heading));
        let (mut d_from, mut d_to) = (Matrix3::zeros(), Matrix3::zeros());
        d_from.fixed_view_mut::<2, 3>(0, 0).copy_from(&(turn * by_from));
        d_from[(2, 2)] = -1.0;
        d_to.fixed_view_mut::<2, 2>(0, 0).copy_from(&(turn * rotation(from.z)));
        d_to[(2, 2)] = 1.0;
        let w = &self.sqrt_information;
        linear(w * residual, vec![dynamic(&(w * d_from)), dynamic(&(w * d_to))])
    }
}
