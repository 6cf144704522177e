//! The maximum of the posterior by Levenberg-Marquardt.

use crate::graph::Graph;
use crate::linear::{Memory, Structure, least_constrained};
use crate::variable::{Key, Values};
use std::fmt;

const INITIAL_DAMPING: f64 = 1e-5;
const MINIMUM_DAMPING: f64 = 1e-10;
const MAXIMUM_DAMPING: f64 = 1e10;
const DAMPING_FACTOR: f64 = 10.0;
/// What multiplies the damping after a step that did all it promised; after one that did next to nothing it
/// doubles (Nielsen 1999).
const LARGEST_CUT: f64 = 0.1;

/// A step's promise that came to nothing, over what counts as none, from which on the solution has stalled; below, curvature
/// and rounding explain it.
const STALL: f64 = 10.0;

/// How a solution ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// At a minimum: no further decrease is predicted.
    Converged,
    /// Steps that promise much bring nothing until damping has made the promise negligible: the function is not smooth
    /// here.
    Stalled,
    /// Out of iterations, at the best values so far.
    IterationLimit,
    /// No step lowers the cost, or it is not a number; the best finite values are kept.
    Diverged,
    /// The factors leave a direction free; the values are a minimum all the same.
    Underconstrained {
        /// The variable that is free.
        near: Key,
    },
    /// There was nothing to estimate from beside odometry.
    NothingObserved,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Converged => write!(f, "converged"),
            Outcome::Stalled => write!(f, "stalled"),
            Outcome::IterationLimit => write!(f, "iteration limit"),
            Outcome::Diverged => write!(f, "diverged"),
            Outcome::Underconstrained { near } => write!(f, "under-constrained near {near}"),
            Outcome::NothingObserved => write!(f, "nothing observed"),
        }
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Most linearisations.
    pub iterations: usize,
    /// Predicted decrease, as a share of the cost or of 1 nat where the cost is less, that counts as none.
    pub tolerance: f64,
}

/// The best values found.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Of all variables, held ones included.
    pub values: Values,
    /// Negative log-posterior, nats, up to a constant; not a number only where the start was undefined.
    pub cost: f64,
    /// How it ended.
    pub outcome: Outcome,
    /// Linearisations done.
    pub iterations: usize,
}

enum Attempt {
    /// The linearised problem predicts no decrease worth the name.
    Negligible,
    /// A lower cost, and the share of the predicted decrease that came true.
    Lower { values: Values, cost: f64, gain: f64 },
    /// Not lower, undefined, or (with an infinite promise) not positive definite.
    Rejected { promised: f64 },
}

/// Minimises the graph's cost over the variables for which `is_free` holds, from `start`.
///
/// Every accepted step lowers the cost, so that the values returned are the best seen. Comparisons are written
/// so that a cost that is not a number never counts as lower.
pub fn solve(graph: &Graph<'_>, start: Values, is_free: impl Fn(Key) -> bool, limits: Limits) -> Solution {
    let mut solution = Solution { values: start, cost: f64::NAN, outcome: Outcome::Diverged, iterations: 0 };
    let Some(cost) = graph.cost(&solution.values) else { return solution };
    solution.cost = cost;
    let Some(structure) = Structure::new(graph, &solution.values, is_free) else { return solution };
    let mut memory = Memory::default();
    let mut damping = INITIAL_DAMPING;
    while solution.iterations < limits.iterations {
        let Some(system) = structure.linearize_in(graph, &solution.values, &mut memory) else {
            return solution;
        };
        solution.iterations += 1;
        let negligible = limits.tolerance * solution.cost.max(1.0);
        let mut attempt = |damping: f64| -> Attempt {
            let Some(step) = system.step(damping, &mut memory) else {
                return Attempt::Rejected { promised: f64::INFINITY };
            };
            if step.predicted_decrease <= negligible {
                return Attempt::Negligible;
            }
            let values = structure.retract(&solution.values, &step);
            match graph.cost(&values) {
                Some(cost) if cost < solution.cost => {
                    let gain = (solution.cost - cost) / step.predicted_decrease;
                    Attempt::Lower { values, cost, gain }
                }
                _ => Attempt::Rejected { promised: step.predicted_decrease },
            }
        };
        let mut result = attempt(damping);
        // Damping alone can make a step look negligible: ask again with next to none.
        if matches!(result, Attempt::Negligible) && damping > MINIMUM_DAMPING {
            damping = MINIMUM_DAMPING;
            result = attempt(damping);
        }
        let mut broken_promise = 0.0;
        while let Attempt::Rejected { promised } = result {
            broken_promise = promised.max(broken_promise);
            damping *= DAMPING_FACTOR;
            if damping > MAXIMUM_DAMPING {
                return solution;
            }
            result = attempt(damping);
        }
        let Attempt::Lower { values, cost, gain } = result else {
            solution.outcome = match least_constrained(&system, &mut memory) {
                Some(near) => Outcome::Underconstrained { near },
                None if broken_promise > STALL * negligible => Outcome::Stalled,
                None => Outcome::Converged,
            };
            return solution;
        };
        system.recycle(&mut memory);
        solution.values = values;
        solution.cost = cost;
        damping = (damping * (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(LARGEST_CUT, 2.0)).max(MINIMUM_DAMPING);
    }
    solution.outcome = Outcome::IterationLimit;
    solution
}
