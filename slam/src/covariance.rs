//! Marginal covariances of single variables, by columns of the inverse of the reduced system.

use crate::linear::{Cholesky, Memory, Reduced, System};
use crate::variable::Key;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par};
use nalgebra::{DMatrix, DVector};

/// Damping tried in turn where the system is singular: what is free then has a variance that is huge, not
/// infinite.
const DAMPING: [f64; 4] = [0.0, 1e-12, 1e-9, 1e-6];
/// Variables whose columns are solved for together.
const BATCH: usize = 16;

/// The Gaussian of the posterior near its maximum (Laplace), variable by variable.
pub struct Marginals<'s> {
    reduced: Reduced<'s>,
    factor: Cholesky<'s>,
}

impl<'s> Marginals<'s> {
    /// Factorises the normal equations at the maximum; `None` where there are none or they are not positive
    /// definite even when damped.
    pub fn new(system: &'s System<'s>) -> Option<Self> {
        let mut memory = Memory::default();
        DAMPING.iter().find_map(|&lambda| {
            let reduced = Reduced::new(system, lambda, &mut memory)?;
            let factor = reduced.factorize(&mut memory)?;
            Some(Self { reduced, factor })
        })
    }

    /// Covariances of poses or points (`[6 x 6]`, `[3 x 3]`, of the right perturbation), `None` for what is
    /// not part of the system.
    pub fn covariances(&self, keys: &[Key]) -> Vec<Option<DMatrix<f64>>> {
        let structure = self.reduced.structure();
        let mut covariances = Vec::with_capacity(keys.len());
        for batch in keys.chunks(BATCH) {
            let spans: Vec<_> = batch.iter().map(|&key| structure.span(key)).collect();
            let columns: Vec<usize> = spans.iter().flatten().cloned().flatten().collect();
            let solved = self.inverse_columns(&columns);
            let mut first = 0;
            for span in spans {
                covariances.push(span.map(|span| {
                    let block = DMatrix::from_fn(span.len(), span.len(), |row, column| {
                        solved[(span.start + row, first + column)]
                    });
                    first += span.len();
                    (&block + block.transpose()) / 2.0
                }));
            }
        }
        covariances
    }

    /// Marginal variances of a latent, `[D]`: its own, given all poses and objects, plus what the
    /// uncertainty of those adds.
    pub fn latent_variance(&self, key: Key) -> Option<DVector<f64>> {
        let index = self.reduced.structure().local_index(key)?;
        let eliminated = &self.reduced.eliminated[index];
        let columns = self.reduced.structure().neighbour_columns(index);
        let solved = self.inverse_columns(&columns);
        let near = Mat::from_fn(columns.len(), columns.len(), |row, column| solved[(columns[row], column)]);

        let lower = eliminated.factor.L();
        let dim = lower.nrows();
        let mut inverse = Mat::identity(dim, dim);
        solve_lower_triangular_in_place(lower, inverse.as_mut(), Par::Seq);
        let mut regression = eliminated.coupling.clone();
        solve_upper_triangular_in_place(lower.transpose(), regression.as_mut(), Par::Seq);
        let spread = &regression * near;
        Some(DVector::from_fn(dim, |i, _| {
            let own: f64 = (i..dim).map(|k| inverse[(k, i)] * inverse[(k, i)]).sum();
            let added: f64 = (0..columns.len()).map(|k| spread[(i, k)] * regression[(i, k)]).sum();
            own + added
        }))
    }

    fn inverse_columns(&self, columns: &[usize]) -> Mat<f64> {
        let mut right = Mat::zeros(self.reduced.structure().columns(), columns.len());
        for (j, &column) in columns.iter().enumerate() {
            right[(column, j)] = 1.0;
        }
        self.factor.solve_in_place(right.as_mut());
        right
    }
}
