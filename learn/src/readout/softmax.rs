//! Multinomial logistic regression.

use nalgebra::{DMatrix, DVector};

/// Precision of the weights' normal prior: the measurement is white, so that one number does for all.
const PRIOR: f64 = 1.0;
const ROUNDS: usize = 300;
/// Change of the weights, relative to them, that counts as none.
const CONVERGED: f64 = 1e-5;

/// Weights `[p, bins]` of most posterior density for inputs `[n, p]` and labels `[n, bins]`, whose rows sum to 1.
///
/// Newton's method with Boehning's bound of the Hessian (1992), `(I - 1 1^T / bins) / 2`: every round raises the density.
pub(super) fn fit(inputs: &DMatrix<f64>, labels: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let bound = inputs.tr_mul(inputs) * 0.5 + DMatrix::identity(inputs.ncols(), inputs.ncols()) * PRIOR;
    let bound = bound.cholesky()?;
    let mut weights = DMatrix::zeros(inputs.ncols(), labels.ncols());
    for _ in 0..ROUNDS {
        let mut missing = labels - probabilities(inputs * &weights);
        missing = inputs.tr_mul(&missing) - &weights * PRIOR;
        let step = bound.solve(&missing);
        weights += &step;
        if step.norm() < CONVERGED * weights.norm() {
            break;
        }
    }
    weights.iter().all(|x| x.is_finite()).then_some(weights)
}

/// The softmax of each row.
pub(super) fn probabilities(mut logits: DMatrix<f64>) -> DMatrix<f64> {
    let most = DVector::from_iterator(logits.nrows(), logits.row_iter().map(|row| row.max()));
    for mut column in logits.column_iter_mut() {
        column -= &most;
        column.apply(|x| *x = libm::exp(*x));
    }
    let sums = logits.column_sum();
    for mut column in logits.column_iter_mut() {
        column.component_div_assign(&sums);
    }
    logits
}
