//! A factor linearised once: a least-squares term over coordinates of variables.

use faer::linalg::matmul::{matmul, triangular};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// Costs `|c + sum_i A_i x_i|^2 / 2`.
#[derive(Clone, Debug)]
pub struct Term {
    /// Numbers of the variables, each once.
    pub variables: Vec<usize>,
    /// `A_i`, `[n x dim]`.
    pub jacobians: Vec<DMatrix<f64>>,
    /// `c`, `[n]`.
    pub constant: DVector<f64>,
}

/// Adds `a^T b` to `target`.
pub(super) fn add_product(target: MatMut<'_, f64>, a: &DMatrix<f64>, b: &DMatrix<f64>) {
    matmul(target, Accum::Add, view(a).transpose(), view(b), 1.0, Par::Seq);
}

/// Adds the lower triangle of `a^T a` to `target`.
pub(super) fn add_square(target: MatMut<'_, f64>, a: &DMatrix<f64>) {
    triangular::matmul(
        target,
        triangular::BlockStructure::TriangularLower,
        Accum::Add,
        view(a).transpose(),
        triangular::BlockStructure::Rectangular,
        view(a),
        triangular::BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
}

fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}
