//! Whether a step is taken, by how much the cost falls against what the linearised factors promise; and how far what stands in the way is
//! damped: Levenberg-Marquardt, where it is needed alone.

use super::tree::Tree;
use std::collections::BTreeMap;

/// Share of the promise that has to come true.
const LEAST_GAIN: f64 = 0.1;
/// Damping at first and at most, as a share of the diagonal of a variable's equations when it is eliminated.
const DAMPING: (f64, f64) = (1e-5, 1e10);
/// What multiplies it after a step that is refused.
const FACTOR: f64 = 10.0;
/// What multiplies it after one that did all it promised; after one that did a tenth of it, 1.5 does (Nielsen 1999).
const LARGEST_CUT: f64 = 0.1;

/// By how much a factor is above its linearisation after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// Nats; infinite where the factor is undefined.
    pub nats: f64,
    /// How much of that rounding, and what residuals may be off unseen, make, nats.
    pub doubt: f64,
}

/// What becomes of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It lowers the cost, by a share of the promise.
    Taken {
        /// The share.
        gain: f64,
    },
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
        Verdict::Taken { gain: if promise > 0.0 { 1.0 - excess / promise } else { 1.0 } }
    } else if excess.is_finite() && excess <= (1.0 - LEAST_GAIN) * promise + doubt {
        Verdict::TakenInDoubt
    } else {
        Verdict::Refused
    }
}

/// Variables that are damped, all by one damping, with how much more each is damped than that.
#[derive(Clone, Debug, Default)]
pub struct Damping {
    damping: f64,
    more: BTreeMap<usize, f64>,
}

impl Damping {
    /// Whether none is.
    pub fn is_none(&self) -> bool {
        self.more.is_empty()
    }

    /// Forgets a variable.
    pub fn forget(&mut self, variable: usize) {
        self.more.remove(&variable);
    }

    /// Damps more than before, and more variables.
    pub fn raise(&mut self, tree: &mut Tree, variables: impl IntoIterator<Item = (usize, f64)>) {
        self.damping = if self.is_none() { DAMPING.0 } else { (FACTOR * self.damping).min(DAMPING.1) };
        self.more.extend(variables);
        self.restore(tree);
    }

    /// Frees all variables in the tree, so that its marginals are those of the factors alone; [`Damping::restore`] goes on.
    pub fn lift(&self, tree: &mut Tree) {
        self.more.keys().for_each(|&variable| tree.damp(variable, 0.0));
    }

    /// Damps again what was before [`Damping::lift`].
    pub fn restore(&self, tree: &mut Tree) {
        self.more.iter().for_each(|(&variable, more)| tree.damp(variable, more * self.damping));
    }

    /// Damps less after a step by which a share of its promise came true, and what is hardly damped not at all.
    pub fn relax(&mut self, tree: &mut Tree, gain: f64) {
        self.damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(LARGEST_CUT);
        if self.damping < DAMPING.0 {
            self.release(tree);
        }
        self.restore(tree);
    }

    /// Damps nothing any more.
    pub fn release(&mut self, tree: &mut Tree) {
        self.lift(tree);
        self.more.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incremental::{Place, Term};
    use approx::assert_relative_eq;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn a_tenth_of_the_promise_has_to_come_true_and_rounding_is_no_rise() {
        let of = |nats: f64, doubt: f64| judge(2.0, [Excess { nats, doubt }].into_iter());
        let is_taken = |nats: f64, share: f64| match of(nats, 0.0) {
            Verdict::Taken { gain } => assert_relative_eq!(gain, share, epsilon = 1e-12),
            other => panic!("{nats}: {other:?}"),
        };
        is_taken(-3.0, 2.5);
        is_taken(0.5, 0.75);
        is_taken(1.79, 0.105);
        assert_eq!(of(1.81, 0.0), Verdict::Refused);
        assert_eq!(of(1.81, 0.02), Verdict::TakenInDoubt);
        assert_eq!(judge(0.0, std::iter::empty()), Verdict::Taken { gain: 1.0 });
        for undefined in [f64::INFINITY, f64::NAN] {
            assert_eq!(of(undefined, 1.0), Verdict::Refused);
        }
    }

    #[test]
    fn damping_grows_by_tens_is_shared_and_goes_where_promises_come_true() {
        let mut tree = Tree::default();
        let variables = [0.0, 1.0].map(|_| tree.add_variable(1, Place::Chain));
        for variable in variables {
            let (jacobians, constant) = (vec![DMatrix::identity(1, 1)], DVector::from_element(1, -1.0));
            tree.add_term(Term { variables: vec![variable], jacobians, constant });
        }
        let solution = |tree: &mut Tree| {
            tree.factorize().unwrap();
            let moved = tree.solve(0.0).moved;
            let at = variables.map(|variable| tree.solution(variable)[0]);
            tree.take_back(&moved);
            at
        };
        let mut damping = Damping::default();
        for _ in 0..4 {
            damping.raise(&mut tree, [(variables[0], 1.0)]);
        }
        // Of a damping of 0.1 and of 10.
        damping.raise(&mut tree, [(variables[1], 100.0)]);
        let [first, second] = solution(&mut tree);
        assert_relative_eq!(first, 1.0 / 1.1, epsilon = 1e-12);
        assert_relative_eq!(second, 1.0 / 11.0, epsilon = 1e-12);
        // Half the promise leaves it, a quarter adds an eighth, all of it cuts it to a tenth.
        damping.relax(&mut tree, 0.5);
        assert_eq!(solution(&mut tree), [first, second]);
        damping.relax(&mut tree, 0.25);
        assert_relative_eq!(solution(&mut tree)[1], 1.0 / 12.25, epsilon = 1e-12);
        damping.relax(&mut tree, 1.0);
        assert_relative_eq!(solution(&mut tree)[1], 1.0 / 2.125, epsilon = 1e-12);
        for _ in 0..4 {
            assert!(!damping.is_none());
            damping.relax(&mut tree, 1.0);
        }
        assert!(damping.is_none());
        assert_eq!(solution(&mut tree), [1.0, 1.0]);
    }
}
