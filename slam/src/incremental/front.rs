//! Dense elimination of a few variables that meet the same others: one front of a multifrontal Cholesky factorisation.

use super::term::{Term, add_product};
use faer::linalg::matmul::{self, triangular};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};

/// The normal equations `H x = -g` over variables to eliminate, F numbers, and their separator, S numbers.
#[derive(Clone, Debug)]
pub struct Front {
    /// Lower triangle, `[(F + S) x (F + S)]`, column by column.
    pub numbers: Vec<f64>,
    /// `g`, `[F + S]`.
    pub gradient: Vec<f64>,
    /// F.
    pub eliminated: usize,
}

/// A front once eliminated: the factor and what is left.
#[derive(Clone, Debug)]
pub struct Eliminated {
    /// `L` above `B = H_SF L^-T`, `[(F + S) x F]`.
    columns: Mat<f64>,
    /// `H_SS - B B^T`, lower triangle column by column.
    rest: Vec<f64>,
    /// `d = L^-1 g_F`, then `g_S - B d`.
    gradient: Vec<f64>,
}

impl Front {
    /// No equation, over `eliminated` and `separator` numbers, in memory that was another's.
    pub fn new(eliminated: usize, separator: usize, mut memory: Vec<f64>) -> Self {
        let n = eliminated + separator;
        memory.clear();
        memory.resize(n * n, 0.0);
        Self { numbers: memory, gradient: vec![0.0; n], eliminated }
    }

    /// `[(F + S) x (F + S)]`, of which the lower triangle counts.
    pub fn matrix(&mut self) -> MatMut<'_, f64> {
        let n = self.gradient.len();
        MatMut::from_column_major_slice_mut(&mut self.numbers, n, n)
    }

    /// Adds a term; `starts` says where each of its variables is here.
    pub fn add_term(&mut self, term: &Term, starts: &[usize]) {
        for (&row, jacobian) in starts.iter().zip(&term.jacobians) {
            let gradient = jacobian.tr_mul(&term.constant);
            let target = &mut self.gradient[row..];
            target.iter_mut().zip(gradient.iter()).for_each(|(t, g)| *t += g);
            for (&column, other) in starts.iter().zip(&term.jacobians).filter(|(column, _)| **column <= row) {
                let (rows, columns) = (jacobian.ncols(), other.ncols());
                add_product(self.matrix().submatrix_mut(row, column, rows, columns), jacobian, other);
            }
        }
    }

    /// Adds what is left of an eliminated front; `places` says for each number of its separator where it is here.
    pub fn add_rest(&mut self, child: &Eliminated, places: &[usize]) {
        let n = self.gradient.len();
        let mut rest = child.rest.as_slice();
        // Stretches of numbers that follow each other here too.
        let ends =
            (1..=places.len()).filter(|&i| places.get(i).is_none_or(|place| *place != places[i - 1] + 1));
        let ends: Vec<usize> = ends.collect();
        let mut stretch = 0;
        for (j, &column) in places.iter().enumerate() {
            let mut from = j;
            for &end in &ends[stretch..] {
                let to = places[from];
                let (values, others) = rest.split_at(end - from);
                if to >= column {
                    let target = &mut self.numbers[column * n + to..][..values.len()];
                    target.iter_mut().zip(values).for_each(|(target, value)| *target += value);
                } else {
                    let target = self.numbers[to * n + column..].iter_mut().step_by(n);
                    target.zip(values).for_each(|(target, value)| *target += value);
                }
                (from, rest) = (end, others);
            }
            stretch += usize::from(ends[stretch] == j + 1);
            self.gradient[column] += child.gradient[child.columns.ncols() + j];
        }
    }

    /// Adds a share of the diagonal, or of 1 where that is less, to those to eliminate.
    pub fn damp(&mut self, share: f64) {
        for i in 0..self.eliminated {
            let diagonal = &mut self.numbers[i * (self.gradient.len() + 1)];
            *diagonal += share * diagonal.max(1.0);
        }
    }

    /// Adds the cost of moving those of some numbers to eliminate that start at `first` away from where they are: a share of the diagonal, or
    /// of 1 where that is less.
    pub fn hold(&mut self, first: usize, at: &[f64], share: f64) {
        for (i, at) in (first..).zip(at) {
            let diagonal = &mut self.numbers[i * (self.gradient.len() + 1)];
            let weight = share * diagonal.max(1.0);
            *diagonal += weight;
            self.gradient[i] -= weight * at;
        }
    }

    /// Eliminates; `None`, with the equations as they were, where they are not positive definite.
    pub fn eliminate(&mut self) -> Option<Eliminated> {
        let (f, n) = (self.eliminated, self.gradient.len());
        let llt = Llt::new(self.matrix().submatrix_mut(0, 0, f, f).rb(), Side::Lower).ok()?;
        let (left, right) = self.matrix().split_at_col_mut(f);
        let mut columns = left.rb().to_owned();
        columns.as_mut().submatrix_mut(0, 0, f, f).copy_from(llt.L());
        let mut below = columns.as_mut().submatrix_mut(f, 0, n - f, f);
        solve_lower_triangular_in_place(llt.L(), below.rb_mut().transpose_mut(), Par::Seq);
        let (_, mut corner) = right.split_at_row_mut(f);
        triangular::matmul(
            corner.rb_mut(),
            triangular::BlockStructure::TriangularLower,
            Accum::Add,
            below.rb(),
            triangular::BlockStructure::Rectangular,
            below.rb().transpose(),
            triangular::BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        let mut rest = Vec::with_capacity((n - f) * (n - f + 1) / 2);
        (f..n).for_each(|j| rest.extend_from_slice(&self.numbers[j * n + j..(j + 1) * n]));
        let mut gradient = self.gradient.clone();
        for j in 0..f {
            let column = columns.col_as_slice(j);
            let d = gradient[j] / column[j];
            gradient[j] = d;
            for (g, l) in gradient[j + 1..].iter_mut().zip(&column[j + 1..]) {
                *g -= l * d;
            }
        }
        gradient.iter().all(|g| g.is_finite()).then_some(Eliminated { columns, rest, gradient })
    }
}

impl Eliminated {
    /// The eliminated numbers, given those of the separator.
    pub fn solve(&self, separator: &[f64]) -> Vec<f64> {
        let (f, n) = (self.columns.ncols(), self.columns.nrows());
        let mut x: Vec<f64> = self.gradient[..f].iter().map(|d| -d).collect();
        let mut column = MatMut::from_column_major_slice_mut(&mut x, f, 1);
        let below = self.columns.as_ref().submatrix(f, 0, n - f, f);
        let given = MatRef::from_column_major_slice(separator, n - f, 1);
        matmul::matmul(column.as_mut(), Accum::Add, below.transpose(), given, -1.0, Par::Seq);
        let lower = self.columns.as_ref().submatrix(0, 0, f, f);
        solve_upper_triangular_in_place(lower.transpose(), column, Par::Seq);
        x
    }

    /// By how much the least-squares cost of the front is above its least given the separator, at some numbers of both.
    pub fn excess(&self, eliminated: &[f64], separator: &[f64]) -> f64 {
        let (f, n) = (self.columns.ncols(), self.columns.nrows());
        let mut rows = Mat::from_fn(f, 1, |i, _| self.gradient[i]);
        let whole = [(0, f, eliminated), (f, n - f, separator)];
        for (start, count, numbers) in whole {
            let block = self.columns.as_ref().submatrix(start, 0, count, f);
            let numbers = MatRef::from_column_major_slice(numbers, count, 1);
            matmul::matmul(rows.as_mut(), Accum::Add, block.transpose(), numbers, 1.0, Par::Seq);
        }
        rows.squared_norm_l2() / 2.0
    }

    /// The covariance of all numbers of the front, `[(F + S) x (F + S)]`, given that of the separator.
    pub fn covariance(&self, separator: MatRef<'_, f64>) -> Mat<f64> {
        let (f, n) = (self.columns.ncols(), self.columns.nrows());
        let lower = self.columns.as_ref().submatrix(0, 0, f, f);
        let below = self.columns.as_ref().submatrix(f, 0, n - f, f);
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
