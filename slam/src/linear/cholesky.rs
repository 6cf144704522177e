//! Sparse Cholesky factors, in memory that is kept from one to the next: fresh pages cost a third of a factorisation.

use super::structure::Structure;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, SymbolicCholeskyRaw};
use faer::{Conj, MatMut, Par, Side};

/// What factorisations of one structure work in, one after the other.
#[derive(Default)]
pub struct Memory {
    /// Of the next factor.
    numbers: Vec<f64>,
    scratch: Option<MemBuffer>,
    /// Of the next system.
    pub(super) hessian: Vec<f64>,
    /// Of the next reduced system.
    pub(super) reduced: Vec<f64>,
}

/// The Cholesky factor of a lower triangle with the structure's pattern.
pub struct Cholesky<'s> {
    symbolic: &'s SymbolicCholesky<usize>,
    numbers: Vec<f64>,
}

impl<'s> Cholesky<'s> {
    /// Factorises; `None` where the matrix is not positive definite, or empty.
    pub fn new(structure: &'s Structure, lower: &[f64], memory: &mut Memory) -> Option<Self> {
        let symbolic = structure.symbolic.as_ref()?;
        let mut numbers = std::mem::take(&mut memory.numbers);
        numbers.resize(symbolic.len_val(), 0.0);
        if memory.scratch.is_none() {
            let needed = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
            memory.scratch = Some(MemBuffer::try_new(needed).ok()?);
        }
        let done = symbolic.factorize_numeric_llt(
            &mut numbers,
            SparseColMatRef::new(structure.pattern(), lower),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(memory.scratch.as_mut()?),
            Default::default(),
        );
        if done.is_err() {
            memory.numbers = numbers;
            return None;
        }
        Some(Self { symbolic, numbers })
    }

    /// Puts the solutions in the place of right-hand sides.
    pub fn solve_in_place(&self, right: MatMut<'_, f64>) {
        let needed = self.symbolic.solve_in_place_scratch::<f64>(right.ncols(), Par::Seq);
        let mut scratch = MemBuffer::new(needed);
        LltRef::new(self.symbolic, &self.numbers).solve_in_place_with_conj(
            Conj::No,
            right,
            Par::Seq,
            MemStack::new(&mut scratch),
        );
    }

    /// Half the logarithm of the matrix's determinant.
    pub fn half_log_det(&self) -> f64 {
        let ln = |x: &f64| libm::log(*x);
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(simplicial) => {
                let starts = &simplicial.col_ptr()[..simplicial.ncols()];
                starts.iter().map(|&start| ln(&self.numbers[start])).sum()
            }
            SymbolicCholeskyRaw::Supernodal(supernodal) => {
                let factor = SupernodalLltRef::new(supernodal, &self.numbers);
                let of_node = |node| {
                    let block = factor.supernode(node).val();
                    (0..block.ncols()).map(|i| ln(&block[(i, i)])).sum::<f64>()
                };
                (0..supernodal.n_supernodes()).map(of_node).sum()
            }
        }
    }

    /// Gives its memory back.
    pub fn recycle(self, memory: &mut Memory) {
        memory.numbers = self.numbers;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::{BetweenFactor, PosePrior};
    use crate::graph::Graph;
    use crate::laplace::{log_evidence, log_evidence_of_all};
    use crate::variable::{Key, Value, Values};
    use approx::assert_relative_eq;
    use nalgebra::Matrix6;
    use vantage_dataset::Pose;

    #[test]
    fn both_kinds_of_factors_have_the_determinant() {
        for (poses, is_supernodal) in [(3, false), (40, true)] {
            let (mut graph, mut values) = (Graph::default(), Values::default());
            graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), Matrix6::identity()));
            for to in 0..poses {
                let place = Pose::translation(to as f64, libm::sin(to as f64), 0.0);
                values.insert(Key::Robot(to), Value::Pose(place));
                for from in 0..to {
                    let information = Matrix6::identity() * (2.0 + libm::cos((from * to) as f64));
                    let (from, to) = (Key::Robot(from), Key::Robot(to));
                    graph.push(BetweenFactor::new(from, to, Pose::identity(), information));
                }
            }
            let structure = Structure::new(&graph, &values, |_| true).unwrap();
            let raw = structure.symbolic.as_ref().unwrap().raw();
            assert_eq!(matches!(raw, SymbolicCholeskyRaw::Supernodal(_)), is_supernodal, "{poses} poses");
            let keys: Vec<Key> = (0..poses).map(Key::Robot).collect();
            let dense = log_evidence(&graph, &values, &keys).unwrap();
            assert_relative_eq!(log_evidence_of_all(&graph, &values).unwrap(), dense, max_relative = 1e-12);
        }
    }
}
