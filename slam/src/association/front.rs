//! A front: some variables with all that they meet, and its elimination.

use crate::incremental::Term;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, Par, Side};
use std::ops::Range;

/// Numbers of a front from which on blocks pay.
const LARGE: usize = 64;

/// The normal equations `H x = -g` over F numbers to eliminate and S of their separator.
pub(super) struct Front {
    /// Lower triangle, `[(F + S) x (F + S)]`, column by column.
    numbers: Vec<f64>,
    gradient: Vec<f64>,
    eliminated: usize,
}

/// A front once eliminated.
#[derive(Clone, Debug)]
pub(super) struct Eliminated {
    /// Variables eliminated here.
    pub variables: Vec<usize>,
    /// Variables they meet that are eliminated later.
    pub separator: Vec<usize>,
    /// `L` above `B = H_SF L^-T`, `[(F + S) x F]`.
    columns: Mat<f64>,
    /// `H_SS - B B^T`, lower triangle column by column.
    rest: Vec<f64>,
    /// `d = L^-1 g_F`, then `g_S - B d`.
    gradient: Vec<f64>,
    /// `log det L`.
    pub log_det: f64,
    /// `|d|^2 / 2`: what the minimum over the eliminated numbers lies below the start.
    pub gain: f64,
}

impl Front {
    /// Without equations, in memory that was another's.
    pub fn new(eliminated: usize, separator: usize, mut memory: Vec<f64>) -> Self {
        let n = eliminated + separator;
        memory.clear();
        memory.resize(n * n, 0.0);
        Self { numbers: memory, gradient: vec![0.0; n], eliminated }
    }

    /// Its memory, for the next.
    pub fn into_memory(self) -> Vec<f64> {
        self.numbers
    }

    /// Adds a term, whose variables start here at `starts`.
    pub fn add_term(&mut self, term: &Term, starts: &[usize]) {
        let n = self.gradient.len();
        for (&row, a) in starts.iter().zip(&term.jacobians) {
            for i in 0..a.ncols() {
                let column = a.column(i);
                self.gradient[row + i] += column.dot(&term.constant);
                for (&other_row, b) in starts.iter().zip(&term.jacobians) {
                    for j in (0..b.ncols()).filter(|j| other_row + j >= row + i) {
                        self.numbers[(row + i) * n + other_row + j] += column.dot(&b.column(j));
                    }
                }
            }
        }
    }

    /// Adds what is left of an eliminated front, each number of whose separator is here at `places`.
    pub fn add_rest(&mut self, child: &Eliminated, places: &[usize]) {
        let n = self.gradient.len();
        let mut rest = child.rest.as_slice();
        for (j, &column) in places.iter().enumerate() {
            let (values, others) = rest.split_at(places.len() - j);
            rest = others;
            for (&row, value) in places[j..].iter().zip(values) {
                let (low, high) = if row < column { (row, column) } else { (column, row) };
                self.numbers[low * n + high] += value;
            }
        }
        let left = &child.gradient[child.columns.ncols()..];
        places.iter().zip(left).for_each(|(&place, g)| self.gradient[place] += g);
    }

    /// `None` where `H_FF` is not positive definite.
    pub fn eliminate(&mut self, variables: Vec<usize>, separator: Vec<usize>) -> Option<Eliminated> {
        let (f, n) = (self.eliminated, self.gradient.len());
        let columns = if n < LARGE { self.eliminate_columns() } else { self.eliminate_blocks() }?;
        let mut rest = Vec::with_capacity((n - f) * (n - f + 1) / 2);
        (f..n).for_each(|j| rest.extend_from_slice(&self.numbers[j * n + j..(j + 1) * n]));
        let mut gradient = self.gradient.clone();
        let (mut log_det, mut gain) = (0.0, 0.0);
        for j in 0..f {
            let column = columns.col_as_slice(j);
            let d = gradient[j] / column[j];
            gradient[j] = d;
            log_det += libm::log(column[j]);
            gain += d * d / 2.0;
            for (g, l) in gradient[j + 1..].iter_mut().zip(&column[j + 1..]) {
                *g -= l * d;
            }
        }
        let finite = log_det.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then_some(Eliminated { variables, separator, columns, rest, gradient, log_det, gain })
    }

    fn eliminate_columns(&mut self) -> Option<Mat<f64>> {
        let (f, n) = (self.eliminated, self.gradient.len());
        for j in 0..f {
            let (before, after) = self.numbers.split_at_mut((j + 1) * n);
            let column = &mut before[j * n + j..];
            let pivot = column[0].sqrt();
            if !pivot.is_normal() {
                return None;
            }
            column.iter_mut().for_each(|x| *x /= pivot);
            for (k, target) in after.chunks_exact_mut(n).enumerate() {
                let l = column[k + 1];
                if l != 0.0 {
                    target[j + 1 + k..].iter_mut().zip(&column[k + 1..]).for_each(|(t, x)| *t -= l * x);
                }
            }
        }
        Some(Mat::from_fn(n, f, |i, j| if i < j { 0.0 } else { self.numbers[j * n + i] }))
    }

    fn eliminate_blocks(&mut self) -> Option<Mat<f64>> {
        let (f, n) = (self.eliminated, self.gradient.len());
        let matrix = MatMut::from_column_major_slice_mut(&mut self.numbers, n, n);
        let (left, right) = matrix.split_at_col_mut(f);
        let llt = Llt::new(left.rb().submatrix(0, 0, f, f), Side::Lower).ok()?;
        let mut columns = left.to_owned();
        columns.as_mut().submatrix_mut(0, 0, f, f).copy_from(llt.L());
        let mut below = columns.as_mut().submatrix_mut(f, 0, n - f, f);
        solve_lower_triangular_in_place(llt.L(), below.rb_mut().transpose_mut(), Par::Seq);
        let (_, corner) = right.split_at_row_mut(f);
        triangular::matmul(
            corner,
            BlockStructure::TriangularLower,
            Accum::Add,
            below.as_ref(),
            BlockStructure::Rectangular,
            below.as_ref().transpose(),
            BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        Some(columns)
    }
}

impl Eliminated {
    /// F.
    pub fn eliminated(&self) -> usize {
        self.columns.ncols()
    }

    /// S.
    pub fn separated(&self) -> usize {
        self.columns.nrows() - self.columns.ncols()
    }

    /// The eliminated numbers, given those of the separator.
    pub fn solve(&self, separator: &[f64]) -> Vec<f64> {
        let f = self.eliminated();
        let mut x = vec![0.0; f];
        for j in (0..f).rev() {
            let column = self.columns.col_as_slice(j);
            let mut sum = -self.gradient[j];
            sum -= dot(&column[j + 1..f], &x[j + 1..]);
            sum -= dot(&column[f..], separator);
            x[j] = sum / column[j];
        }
        x
    }

    /// Forward substitution of one right side: `right` over the eliminated numbers becomes `y = L^-1 right`, and `B y` is taken off `separator`.
    pub fn forward(&self, right: &mut [f64], separator: &mut [f64]) {
        let f = self.eliminated();
        let first = right.iter().position(|x| *x != 0.0).unwrap_or(f);
        for j in first..f {
            let column = self.columns.col_as_slice(j);
            let y = right[j] / column[j];
            right[j] = y;
            right[j + 1..].iter_mut().zip(&column[j + 1..f]).for_each(|(r, l)| *r -= l * y);
            separator.iter_mut().zip(&column[f..]).for_each(|(r, l)| *r -= l * y);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let tail: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        (0..4).for_each(|i| sums[i] += a[i] * b[i]);
    }
    sums.iter().sum::<f64>() + tail
}

/// Where each of these variables' numbers lie, one variable behind the other.
pub(super) fn spans(dims: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut end = 0;
    dims.map(|dim| {
        end += dim;
        end - dim..end
    })
    .collect()
}
