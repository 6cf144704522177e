//! The system of poses and objects that is left once every latent is eliminated inside its own object.

use super::cholesky::{Cholesky, Memory};
use super::structure::Structure;
use super::system::{System, local_damping_scale};
use faer::linalg::matmul::triangular;
use faer::linalg::solvers::Llt as DenseLlt;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, Mat, Par, Side};

/// The Schur complement of the latents in `H + lambda D`.
pub struct Reduced<'s> {
    structure: &'s Structure,
    /// Lower triangle.
    pub(super) hessian: Vec<f64>,
    gradient: Vec<f64>,
    pub(crate) eliminated: Vec<Eliminated>,
}

/// One latent, eliminated.
pub(crate) struct Eliminated {
    /// Lower Cholesky factor of the latent's block, `[D x D]`.
    pub factor: DenseLlt<f64>,
    /// The factor's inverse times the coupling, `[D x width]`.
    pub coupling: Mat<f64>,
    /// The factor's inverse times the gradient, `[D x 1]`.
    gradient: Mat<f64>,
}

impl<'s> Reduced<'s> {
    /// Eliminates the latents; `None` where one's block is not positive definite.
    pub fn new(system: &'s System<'s>, lambda: f64, memory: &mut Memory) -> Option<Self> {
        let structure = system.structure;
        let mut hessian = std::mem::take(&mut memory.reduced);
        hessian.clone_from(&system.hessian);
        let mut reduced = Self {
            structure,
            hessian,
            gradient: system.gradient.clone(),
            eliminated: Vec::with_capacity(system.locals.len()),
        };
        if lambda > 0.0 {
            for column in 0..structure.columns {
                reduced.hessian[structure.column_starts[column]] += lambda * system.scale(column);
            }
        }
        for (index, local) in system.locals.iter().enumerate() {
            let key = structure.locals[index].key;
            let mut block = local.hessian.clone();
            for i in 0..block.nrows() {
                block[(i, i)] += lambda * local_damping_scale(key, local.hessian[(i, i)]);
            }
            let factor = DenseLlt::new(block.as_ref(), Side::Lower).ok()?;
            let mut coupling = local.coupling.clone();
            let mut gradient = Mat::from_fn(local.gradient.len(), 1, |i, _| local.gradient[i]);
            solve_lower_triangular_in_place(factor.L(), coupling.as_mut(), Par::Seq);
            solve_lower_triangular_in_place(factor.L(), gradient.as_mut(), Par::Seq);
            reduced.subtract(index, &coupling, &gradient)?;
            reduced.eliminated.push(Eliminated { factor, coupling, gradient });
        }
        Some(reduced)
    }

    /// Where each variable sits.
    pub fn structure(&self) -> &'s Structure {
        self.structure
    }

    /// Subtracts `Z^T Z` and `Z^T z` of one latent.
    fn subtract(&mut self, index: usize, coupling: &Mat<f64>, gradient: &Mat<f64>) -> Option<()> {
        let local = &self.structure.locals[index];
        let mut product = Mat::zeros(local.width, local.width);
        triangular::matmul(
            product.as_mut(),
            triangular::BlockStructure::TriangularLower,
            Accum::Replace,
            coupling.transpose(),
            triangular::BlockStructure::Rectangular,
            coupling.as_ref(),
            triangular::BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        let projected = coupling.transpose() * gradient;
        for (&block_a, &offset_a) in &local.neighbours {
            let kept_a = self.structure.kept[block_a];
            for row in 0..kept_a.dim {
                self.gradient[kept_a.column + row] -= projected[(offset_a + row, 0)];
            }
            for (&block_b, &offset_b) in local.neighbours.range(..=block_a) {
                let shift = self.structure.shift((block_a, block_b))?;
                for column in 0..self.structure.kept[block_b].dim {
                    let first_row = if block_a == block_b { column } else { 0 };
                    let start = self.structure.entry(block_b, shift, first_row, column);
                    for row in first_row..kept_a.dim {
                        self.hessian[start + row - first_row] -= product[(offset_a + row, offset_b + column)];
                    }
                }
            }
        }
        Some(())
    }

    /// The sparse Cholesky factor, or `None` where the system is not positive definite, or empty.
    pub fn factorize(&self, memory: &mut Memory) -> Option<Cholesky<'s>> {
        Cholesky::new(self.structure, &self.hessian, memory)
    }

    /// Half the logarithm of the determinant of the whole system, latents included; `None` where it is not positive definite.
    pub fn half_log_det(&self, memory: &mut Memory) -> Option<f64> {
        let of_locals = |eliminated: &Eliminated| {
            let lower = eliminated.factor.L();
            (0..lower.nrows()).map(|i| libm::log(lower[(i, i)])).sum::<f64>()
        };
        let kept = match self.structure.columns {
            0 => 0.0,
            _ => self.factorize(memory)?.half_log_det(),
        };
        Some(kept + self.eliminated.iter().map(of_locals).sum::<f64>())
    }

    /// Gives its memory back.
    pub(super) fn recycle(self, memory: &mut Memory) {
        memory.reduced = self.hessian;
    }

    /// The step of the kept variables by column, and of each latent.
    pub(super) fn solve(&self, memory: &mut Memory) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let columns = self.structure.columns;
        let mut kept = Mat::from_fn(columns, 1, |i, _| -self.gradient[i]);
        if columns > 0 {
            let factor = self.factorize(memory)?;
            factor.solve_in_place(kept.as_mut());
            factor.recycle(memory);
        }
        let locals = self
            .structure
            .locals
            .iter()
            .zip(&self.eliminated)
            .map(|(local, eliminated)| {
                let mut near = Mat::zeros(local.width, 1);
                for (&block, &offset) in &local.neighbours {
                    let neighbour = self.structure.kept[block];
                    for i in 0..neighbour.dim {
                        near[(offset + i, 0)] = kept[(neighbour.column + i, 0)];
                    }
                }
                let mut delta = -(&eliminated.coupling * near + &eliminated.gradient);
                solve_upper_triangular_in_place(eliminated.factor.L().transpose(), delta.as_mut(), Par::Seq);
                (0..local.dim).map(|i| delta[(i, 0)]).collect()
            })
            .collect();
        Some(((0..columns).map(|i| kept[(i, 0)]).collect(), locals))
    }
}
