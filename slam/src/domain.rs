//! What of a whole episode differs from what its model was trained on: an affine change of all predictions, a variable beside the others.
//! It is the part of the parameters `theta` that Eq. 25-26 learn along with the trajectory, under a prior at what training found.
//!
//! ```text
//! p(m(z) | e, x_rel, u) = p(m(z) | h(e, x_rel) + V (s_o D b + s_g g * V^T h)),   u = (b, g) ~ N(0, I)
//! ```
//!
//! `h` is the model's prediction. The columns of `V` are the directions in which the model errs most, the principal axes of its noise, with
//! the deviations `D`. `b` moves all predictions along them, `g` scales them.

use garde::Validate;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;
use vantage_model::MeasurementNoise;

/// Directions of the change, at most: 32 numbers.
const DIRECTIONS: usize = 16;

/// How far an episode may differ from training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct DomainPrior {
    /// Deviation of the offset, in those of the model's noise.
    #[garde(range(min = 0.0, max = 100.0), custom(not_nan))]
    pub offset_sigma: f64,
    /// Deviation of the gain less 1.
    #[garde(range(min = 0.0, max = 10.0), custom(not_nan))]
    pub gain_sigma: f64,
}

impl Default for DomainPrior {
    fn default() -> Self {
        Self { offset_sigma: 1.0, gain_sigma: 0.1 }
    }
}

/// The change of a model's predictions, by its numbers `u`: offsets, then gains.
#[derive(Clone, Debug)]
pub struct Domain {
    /// `V`, `[M x K]`.
    axes: DMatrix<f64>,
    /// `s_o D`, `[K]`.
    offsets: DVector<f64>,
    gain_sigma: f64,
}

impl Domain {
    /// Along the directions in which a model errs most.
    pub fn new(noise: &MeasurementNoise, prior: &DomainPrior) -> Self {
        let whiten = noise.sqrt_information();
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(whiten.tr_mul(whiten));
        let mut order: Vec<usize> = (0..eigenvalues.len()).collect();
        order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]).then(a.cmp(&b)));
        order.truncate(DIRECTIONS);
        Self {
            axes: DMatrix::from_fn(eigenvectors.nrows(), order.len(), |i, k| eigenvectors[(i, order[k])]),
            offsets: DVector::from_fn(order.len(), |k, _| prior.offset_sigma / eigenvalues[order[k]].sqrt()),
            gain_sigma: prior.gain_sigma,
        }
    }

    /// Numbers of `u`.
    pub fn dim(&self) -> usize {
        2 * self.offsets.len()
    }

    /// A prediction `h` as it is in this domain, `[M]`.
    pub fn changed(&self, u: &DVector<f64>, h: &DVector<f64>) -> DVector<f64> {
        h + self.by_numbers(h) * u
    }

    /// Its derivative by `u`, `[M x dim]`.
    pub fn by_numbers(&self, h: &DVector<f64>) -> DMatrix<f64> {
        let (along, k) = (self.axes.tr_mul(h), self.offsets.len());
        DMatrix::from_fn(h.len(), 2 * k, |i, j| match j.checked_sub(k) {
            None => self.axes[(i, j)] * self.offsets[j],
            Some(gain) => self.axes[(i, gain)] * self.gain_sigma * along[gain],
        })
    }

    /// Its derivative by `h`, `[M x M]`.
    pub fn by_prediction(&self, u: &DVector<f64>) -> DMatrix<f64> {
        let k = self.offsets.len();
        let mut scaled = self.axes.clone();
        for (gain, mut column) in scaled.column_iter_mut().enumerate() {
            column *= self.gain_sigma * u[k + gain];
        }
        DMatrix::identity(self.axes.nrows(), self.axes.nrows()) + scaled * self.axes.transpose()
    }
}
