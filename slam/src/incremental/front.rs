//! Dense elimination of a few variables that meet the same others: one front of a multifrontal Cholesky factorisation.

use super::term::{Term, add_product};
use faer::linalg::matmul::triangular;
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatRef, Par, Side};

/// The normal equations `H x = -g` over variables to eliminate, F numbers, and their separator, S numbers; once eliminated, the
/// factor and what is left.
#[derive(Clone, Debug)]
pub struct Front {
    /// Lower triangle, `[(F + S) x (F + S)]`. Eliminated: `L` and `B = H_SF L^-T` in the first F columns, `H_SS - B B^T` in the others.
    pub matrix: Mat<f64>,
    /// `g`, `[F + S]`. Eliminated: `d = L^-1 g_F`, then `g_S - B d`.
    pub gradient: Vec<f64>,
    /// F.
    pub eliminated: usize,
}

impl Front {
    /// No equation, over `eliminated` and `separator` numbers.
    pub fn new(eliminated: usize, separator: usize) -> Self {
        let n = eliminated + separator;
        Self { matrix: Mat::zeros(n, n), gradient: vec![0.0; n], eliminated }
    }

    /// Adds a term; `starts` says where each of its variables is here.
    pub fn add_term(&mut self, term: &Term, starts: &[usize]) {
        for (&row, jacobian) in starts.iter().zip(&term.jacobians) {
            let gradient = jacobian.tr_mul(&term.constant);
            let target = &mut self.gradient[row..];
            target.iter_mut().zip(gradient.iter()).for_each(|(t, g)| *t += g);
            for (&column, other) in starts.iter().zip(&term.jacobians).filter(|(column, _)| **column <= row) {
                let (rows, columns) = (jacobian.ncols(), other.ncols());
                add_product(self.matrix.as_mut().submatrix_mut(row, column, rows, columns), jacobian, other);
            }
        }
    }

    /// Adds what is left of an eliminated front; `places` says for each number of its separator where it is here.
    pub fn add_rest(&mut self, child: &Front, places: &[usize]) {
        let first = child.eliminated;
        for (j, &column) in places.iter().enumerate() {
            let source = &child.matrix.col_as_slice(first + j)[first + j..];
            for (value, &row) in source.iter().zip(&places[j..]) {
                let (row, column) = (row.max(column), row.min(column));
                self.matrix[(row, column)] += value;
            }
            self.gradient[column] += child.gradient[first + j];
        }
    }

    /// Adds a share of the diagonal, or of 1 where that is less, to those to eliminate.
    pub fn damp(&mut self, share: f64) {
        for i in 0..self.eliminated {
            let diagonal = &mut self.matrix[(i, i)];
            *diagonal += share * diagonal.max(1.0);
        }
    }

    /// Eliminates; false where the equations are not positive definite.
    pub fn eliminate(&mut self) -> bool {
        let f = self.eliminated;
        let Ok(llt) = Llt::new(self.matrix.as_ref().submatrix(0, 0, f, f), Side::Lower) else { return false };
        let factor = llt.L();
        self.matrix.as_mut().submatrix_mut(0, 0, f, f).copy_from(factor);
        let (left, right) = self.matrix.as_mut().split_at_col_mut(f);
        let (_, mut below) = left.split_at_row_mut(f);
        solve_lower_triangular_in_place(factor, below.as_mut().transpose_mut(), Par::Seq);
        let (_, corner) = right.split_at_row_mut(f);
        triangular::matmul(
            corner,
            triangular::BlockStructure::TriangularLower,
            Accum::Add,
            below.as_ref(),
            triangular::BlockStructure::Rectangular,
            below.as_ref().transpose(),
            triangular::BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        for j in 0..f {
            let column = self.matrix.col_as_slice(j);
            let d = self.gradient[j] / column[j];
            self.gradient[j] = d;
            for (g, l) in self.gradient[j + 1..].iter_mut().zip(&column[j + 1..]) {
                *g -= l * d;
            }
        }
        self.gradient.iter().all(|g| g.is_finite())
    }

    /// The eliminated numbers, given those of the separator.
    pub fn solve(&self, separator: &[f64]) -> Vec<f64> {
        let f = self.eliminated;
        let mut x = vec![0.0; f];
        for j in (0..f).rev() {
            let column = self.matrix.col_as_slice(j);
            let within: f64 = column[j + 1..f].iter().zip(&x[j + 1..]).map(|(l, x)| l * x).sum();
            let beyond: f64 = column[f..].iter().zip(separator).map(|(b, x)| b * x).sum();
            x[j] = -(self.gradient[j] + within + beyond) / column[j];
        }
        x
    }

    /// The covariance of all numbers of the front, `[(F + S) x (F + S)]`, given that of the separator.
    pub fn covariance(&self, separator: MatRef<'_, f64>) -> Mat<f64> {
        let (f, n) = (self.eliminated, self.gradient.len());
        let lower = self.matrix.as_ref().submatrix(0, 0, f, f);
        let below = self.matrix.as_ref().submatrix(f, 0, n - f, f);
        let mut inverse = Mat::<f64>::identity(f, f);
        solve_lower_triangular_in_place(lower, inverse.as_mut(), Par::Seq);
        // x_F = -L^-T B^T x_S and noise of covariance L^-T L^-1.
        let regression = inverse.transpose() * below.transpose() * faer::Scale(-1.0);
        let across = &regression * separator;
        let own = inverse.transpose() * &inverse + &across * regression.transpose();
        let mut whole = Mat::zeros(n, n);
        whole.as_mut().submatrix_mut(0, 0, f, f).copy_from(&own);
        whole.as_mut().submatrix_mut(0, f, f, n - f).copy_from(&across);
        whole.as_mut().submatrix_mut(f, 0, n - f, f).copy_from(across.transpose());
        whole.as_mut().submatrix_mut(f, f, n - f, n - f).copy_from(separator);
        whole
    }
}
