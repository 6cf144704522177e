//! The equations of what is eliminated inside its own object, kept from step to step: a new view adds to them.

use super::front::Front;
use super::term::{Term, add_product, add_square};
use faer::Mat;
use std::collections::BTreeMap;

/// Sums of the terms of one object over its own variables and the ones that it is seen from.
#[derive(Clone, Debug, Default)]
pub struct ObjectEquations {
    /// Own variables and then the others, in the order met.
    variables: Vec<usize>,
    /// Where each is in `variables`.
    places: BTreeMap<usize, usize>,
    own: usize,
    /// F.
    eliminated: usize,
    /// `[F x dim]` for each variable: own ones, lower triangle, and the coupling to others.
    top: Vec<Mat<f64>>,
    /// Blocks among the others, of (row, column) in `variables`, lower triangle.
    bottom: BTreeMap<(usize, usize), Mat<f64>>,
    gradient: Vec<f64>,
}

impl ObjectEquations {
    /// No equation over own variables, given with their dimensions.
    pub fn new(own: &[(usize, usize)]) -> Self {
        let eliminated = own.iter().map(|(_, dim)| dim).sum();
        let mut equations = Self { own: own.len(), eliminated, ..Self::default() };
        for &(variable, dim) in own {
            equations.meet(variable, dim);
        }
        equations
    }

    fn meet(&mut self, variable: usize, dim: usize) {
        if !self.places.contains_key(&variable) {
            self.places.insert(variable, self.variables.len());
            self.variables.push(variable);
            self.top.push(Mat::zeros(self.eliminated, dim));
            self.gradient.extend(std::iter::repeat_n(0.0, dim));
        }
    }

    /// Own variables.
    pub fn eliminated(&self) -> &[usize] {
        &self.variables[..self.own]
    }

    /// Variables that are not the object's own, in the order of its separator.
    pub fn separator(&self) -> &[usize] {
        &self.variables[self.own..]
    }

    /// The first number of each variable.
    fn starts(&self) -> Vec<usize> {
        let mut next = 0;
        self.top
            .iter()
            .map(|top| {
                let start = next;
                next += top.ncols();
                start
            })
            .collect()
    }

    /// Adds a term.
    pub fn add(&mut self, term: &Term) {
        for (&variable, jacobian) in term.variables.iter().zip(&term.jacobians) {
            self.meet(variable, jacobian.ncols());
        }
        let starts = self.starts();
        let members = || term.variables.iter().map(|variable| self.places[variable]).zip(&term.jacobians);
        let members: Vec<_> = members().collect();
        for &(row, jacobian) in &members {
            let gradient = jacobian.tr_mul(&term.constant);
            let target = &mut self.gradient[starts[row]..];
            target.iter_mut().zip(gradient.iter()).for_each(|(t, g)| *t += g);
            for &(column, other) in &members {
                let (rows, columns) = (jacobian.ncols(), other.ncols());
                let is_lower = column <= row;
                if row < self.own && (column >= self.own || is_lower) {
                    let target = self.top[column].as_mut().subrows_mut(starts[row], rows);
                    if row == column {
                        add_square(target, jacobian);
                    } else {
                        add_product(target, jacobian, other);
                    }
                } else if row >= self.own && column >= self.own && is_lower {
                    let block = self.bottom.entry((row, column)).or_insert_with(|| Mat::zeros(rows, columns));
                    add_product(block.as_mut(), jacobian, other);
                }
            }
        }
    }

    /// The front that eliminates the object, in memory that was another's.
    pub fn front(&self, memory: Vec<f64>) -> Front {
        let starts = self.starts();
        let mut front = Front::new(self.eliminated, self.gradient.len() - self.eliminated, memory);
        front.gradient.copy_from_slice(&self.gradient);
        for (index, (&start, block)) in starts.iter().zip(&self.top).enumerate() {
            let size = (self.eliminated, block.ncols());
            let matrix = front.matrix();
            if index < self.own {
                matrix.submatrix_mut(0, start, size.0, size.1).copy_from(block);
            } else {
                matrix.submatrix_mut(start, 0, size.1, size.0).copy_from(block.transpose());
            }
        }
        for (&(row, column), block) in &self.bottom {
            front
                .matrix()
                .submatrix_mut(starts[row], starts[column], block.nrows(), block.ncols())
                .copy_from(block);
        }
        front
    }
}
