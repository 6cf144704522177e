//! Whether a step is taken, by how much the cost falls against what the linearised factors promise; and how far what stands in the way is
//! damped: Levenberg-Marquardt, where it is needed alone.

use super::tree::Tree;
use std::collections::{BTreeMap, BTreeSet};

/// Share of the promise that has to come true.
const LEAST_GAIN: f64 = 0.1;
/// Damping of a variable at first and at most, as a share of the diagonal of its equations.
const DAMPING: (f64, f64) = (1e-2, 1e8);
/// What multiplies it after a step that is refused, and divides it after one that is taken.
const FACTOR: f64 = 10.0;
/// Share of the largest excess from which on a factor stands in the way.
const IN_THE_WAY: f64 = 0.1;

/// By how much a factor is above its linearisation after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// Nats; infinite where the factor is undefined.
    pub nats: f64,
    /// How much of that rounding, and what residuals may be off unseen, make, nats.
    pub doubt: f64,
}

/// What becomes of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It lowers the cost.
    Taken,
    /// It may: the rise is in doubt.
    TakenInDoubt,
    /// It does not.
    Refused,
}

/// Of a step by which the linearised factors fall by `promise` nats.
pub fn judge(promise: f64, factors: impl Iterator<Item = Excess>) -> Verdict {
    let (mut excess, mut doubt) = (0.0, 0.0);
    for factor in factors {
        excess += factor.nats;
        doubt += factor.doubt;
    }
    if excess <= (1.0 - LEAST_GAIN) * promise {
        Verdict::Taken
    } else if excess.is_finite() && excess <= (1.0 - LEAST_GAIN) * promise + doubt {
        Verdict::TakenInDoubt
    } else {
        Verdict::Refused
    }
}

/// Variables that are damped.
#[derive(Clone, Debug, Default)]
pub struct Damping(BTreeMap<usize, f64>);

impl Damping {
    /// Whether none is.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Forgets a variable.
    pub fn forget(&mut self, variable: usize) {
        self.0.remove(&variable);
    }

    /// Damps the variables of the terms that stood most in the way of a step, more than before.
    pub fn raise(&mut self, tree: &mut Tree, terms: &[(usize, Excess)]) {
        let largest = terms.iter().map(|(_, excess)| excess.nats).fold(0.0, f64::max);
        let in_the_way = terms.iter().filter(|(_, excess)| excess.nats >= IN_THE_WAY * largest);
        let of_terms = in_the_way.filter_map(|(term, _)| Some(&tree.term(*term)?.variables));
        let variables: BTreeSet<usize> = of_terms.flatten().copied().collect();
        for variable in variables {
            let damping =
                self.0.entry(variable).and_modify(|damping| *damping *= FACTOR).or_insert(DAMPING.0);
            *damping = damping.min(DAMPING.1);
            tree.damp(variable, *damping);
        }
    }

    /// Frees all variables in the tree, so that its marginals are those of the factors alone; [`Damping::restore`] goes on.
    pub fn lift(&self, tree: &mut Tree) {
        self.0.keys().for_each(|&variable| tree.damp(variable, 0.0));
    }

    /// Damps again what was before [`Damping::lift`].
    pub fn restore(&self, tree: &mut Tree) {
        self.0.iter().for_each(|(&variable, &damping)| tree.damp(variable, damping));
    }

    /// Damps all variables less, those that hardly were not at all.
    pub fn relax(&mut self, tree: &mut Tree) {
        self.0.retain(|&variable, damping| {
            *damping /= FACTOR;
            let is_kept = *damping >= DAMPING.0;
            tree.damp(variable, if is_kept { *damping } else { 0.0 });
            is_kept
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incremental::{Place, Term};
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn a_tenth_of_the_promise_has_to_come_true_and_rounding_is_no_rise() {
        let of = |nats: f64, doubt: f64| judge(1.0, [Excess { nats, doubt }].into_iter());
        assert_eq!(of(-3.0, 0.0), Verdict::Taken);
        assert_eq!(of(0.89, 0.0), Verdict::Taken);
        assert_eq!(of(0.91, 0.0), Verdict::Refused);
        assert_eq!(of(0.91, 0.02), Verdict::TakenInDoubt);
        for undefined in [f64::INFINITY, f64::NAN] {
            assert_eq!(of(undefined, 1.0), Verdict::Refused);
        }
    }

    #[test]
    fn what_stands_in_the_way_is_damped_until_steps_are_taken() {
        let mut tree = Tree::default();
        let variables = [0.0, 1.0].map(|_| tree.add_variable(1, Place::Chain));
        let terms = variables.map(|variable| {
            let (jacobians, constant) = (vec![DMatrix::identity(1, 1)], DVector::from_element(1, -1.0));
            tree.add_term(Term { variables: vec![variable], jacobians, constant })
        });
        let solution = |tree: &mut Tree| {
            tree.factorize().unwrap();
            let moved = tree.solve(0.0).moved;
            let at = variables.map(|variable| tree.solution(variable)[0]);
            tree.take_back(&moved);
            at
        };
        let mut damping = Damping::default();
        let excess = |nats| Excess { nats, doubt: 0.0 };
        for _ in 0..3 {
            damping.raise(&mut tree, &[(terms[0], excess(10.0)), (terms[1], excess(0.1))]);
        }
        // A damping of 1 doubles the diagonal.
        let [first, second] = solution(&mut tree);
        assert!((first - 0.5).abs() < 1e-12 && (second - 1.0).abs() < 1e-12, "{first}, {second}");
        for _ in 0..3 {
            assert!(!damping.is_none());
            damping.relax(&mut tree);
        }
        assert!(damping.is_none());
        assert_eq!(solution(&mut tree), [1.0, 1.0]);
    }
}
