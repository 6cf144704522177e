//! The numeric half: the normal equations at one point.

use super::cholesky::Memory;
use super::structure::{Place, Structure};
use crate::factor::LinearFactor;
use crate::graph::Graph;
use crate::variable::{Key, Values};
use faer::linalg::matmul::{matmul, triangular};
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// Bounds of the damping's scale D = diag(J^T W J), as in Ceres.
const DAMPING_SCALE: (f64, f64) = (1e-6, 1e32);
/// How much more a latent is damped. A network bends more in its latent than the rest of the problem in its poses, and
/// damping strong enough for the latent would hold a chain of poses, whose soft directions are far below its diagonal.
const LATENT_DAMPING: f64 = 1e4;

/// `H = J^T W J` and `g = J^T W r` of a graph at a point.
pub struct System<'s> {
    pub(super) structure: &'s Structure,
    /// Lower triangle over kept variables, before anything is eliminated.
    pub(super) hessian: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    pub(super) locals: Vec<LocalSystem>,
}

/// The rows of one latent or offset.
pub(super) struct LocalSystem {
    /// `[D x D]`, lower triangle.
    pub hessian: Mat<f64>,
    /// `[D x width]`: with the neighbours, in their order.
    pub coupling: Mat<f64>,
    pub gradient: Vec<f64>,
}

impl Structure {
    /// The normal equations at `values`, or `None` where a factor is undefined.
    pub fn linearize(&self, graph: &Graph<'_>, values: &Values) -> Option<System<'_>> {
        self.linearize_in(graph, values, &mut Memory::default())
    }

    /// [`Structure::linearize`], in memory that is kept.
    pub fn linearize_in(
        &self,
        graph: &Graph<'_>,
        values: &Values,
        memory: &mut Memory,
    ) -> Option<System<'_>> {
        let mut hessian = std::mem::take(&mut memory.hessian);
        hessian.clear();
        hessian.resize(self.entries(), 0.0);
        let mut system = System {
            structure: self,
            hessian,
            gradient: vec![0.0; self.columns],
            locals: self
                .locals
                .iter()
                .map(|local| LocalSystem {
                    hessian: Mat::zeros(local.dim, local.dim),
                    coupling: Mat::zeros(local.dim, local.width),
                    gradient: vec![0.0; local.dim],
                })
                .collect(),
        };
        for factor in graph.factors() {
            let mut linear = factor.linearize(values)?;
            let s = linear.residual.norm_squared();
            let weight = factor.information_scale() * factor.kernel().weight(s, linear.residual.len());
            let root = weight.sqrt();
            linear.residual *= root;
            for jacobian in &mut linear.jacobians {
                *jacobian *= root;
            }
            system.add(factor.keys(), &linear)?;
        }
        let finite = system.gradient.iter().chain(&system.hessian).all(|x| x.is_finite())
            && system.locals.iter().all(|local| local.gradient.iter().all(|x| x.is_finite()));
        finite.then_some(system)
    }
}

impl System<'_> {
    /// Gives its memory back.
    pub fn recycle(self, memory: &mut Memory) {
        memory.hessian = self.hessian;
    }

    fn add(&mut self, keys: &[Key], linear: &LinearFactor) -> Option<()> {
        let structure = self.structure;
        let mut kept: Vec<(usize, &DMatrix<f64>)> = Vec::with_capacity(keys.len());
        let mut local = None;
        for (key, jacobian) in keys.iter().zip(&linear.jacobians) {
            match structure.places.get(key) {
                Some(Place::Kept(block)) => kept.push((*block, jacobian)),
                Some(Place::Local(index)) => local = Some((*index, jacobian)),
                None => {}
            }
        }
        for &(a, jacobian_a) in &kept {
            let first = structure.kept[a].column;
            add_to(&mut self.gradient[first..], &jacobian_a.tr_mul(&linear.residual));
            for &(b, jacobian_b) in kept.iter().filter(|(b, _)| *b <= a) {
                let shift = structure.shift((a, b))?;
                for (column, by_column) in jacobian_b.column_iter().enumerate() {
                    let first_row = if a == b { column } else { 0 };
                    let start = structure.entry(b, shift, first_row, column);
                    let rows = jacobian_a.ncols() - first_row;
                    for (row, target) in self.hessian[start..start + rows].iter_mut().enumerate() {
                        *target += jacobian_a.column(first_row + row).dot(&by_column);
                    }
                }
            }
        }
        if let Some((index, jacobian)) = local {
            self.add_local(index, jacobian, &kept, &linear.residual)?;
        }
        Some(())
    }

    fn add_local(
        &mut self,
        index: usize,
        jacobian: &DMatrix<f64>,
        kept: &[(usize, &DMatrix<f64>)],
        residual: &DVector<f64>,
    ) -> Option<()> {
        let layout = &self.structure.locals[index];
        let local = &mut self.locals[index];
        let transposed = view(jacobian).transpose();
        triangular::matmul(
            local.hessian.as_mut(),
            triangular::BlockStructure::TriangularLower,
            Accum::Add,
            transposed,
            triangular::BlockStructure::Rectangular,
            view(jacobian),
            triangular::BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        for &(block, jacobian_kept) in kept {
            let offset = *layout.neighbours.get(&block)?;
            let target = local.coupling.as_mut().subcols_mut(offset, jacobian_kept.ncols());
            matmul(target, Accum::Add, transposed, view(jacobian_kept), 1.0, Par::Seq);
        }
        add_to(&mut local.gradient, &jacobian.tr_mul(residual));
        Some(())
    }

    /// D of a column of the reduced system.
    pub(super) fn scale(&self, column: usize) -> f64 {
        damping_scale(self.hessian[self.structure.column_starts[column]])
    }
}

fn damping_scale(diagonal: f64) -> f64 {
    diagonal.clamp(DAMPING_SCALE.0, DAMPING_SCALE.1)
}

/// D of a number of a variable that is eliminated inside its object.
pub(super) fn local_damping_scale(key: Key, diagonal: f64) -> f64 {
    more_damped(key) * damping_scale(diagonal)
}

/// How much more a variable is damped than others.
pub fn more_damped(key: Key) -> f64 {
    if matches!(key, Key::Latent(_)) { LATENT_DAMPING } else { 1.0 }
}

fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

fn add_to(target: &mut [f64], source: &DVector<f64>) {
    for (t, s) in target.iter_mut().zip(source.iter()) {
        *t += s;
    }
}
