//! What may have been seen.

use super::estimator::Addition;

/// One way to take a measurement.
#[derive(Clone)]
pub struct Alternative<'m> {
    /// Its name in the verdict.
    pub label: usize,
    /// What it adds to the estimate.
    pub addition: Addition<'m>,
    /// `log` of its prior, and of what makes its factors densities of the measurement; nats.
    pub log_weight: f64,
    /// An object that no other choice of the same frame may claim.
    pub claims: Option<usize>,
}

/// A measurement that may be taken in several ways, exactly one of which is right.
#[derive(Clone)]
pub struct Choice<'m> {
    /// Its number.
    pub number: usize,
    /// The ways.
    pub alternatives: Vec<Alternative<'m>>,
}

/// Choices of one moment.
#[derive(Clone, Default)]
pub struct Frame<'m> {
    /// The choices, in order.
    pub choices: Vec<Choice<'m>>,
    /// `log` of what all ways have in common, which need not be the same for all hypotheses: that objects in view were missed.
    pub log_weight: f64,
}

/// What a hypothesis takes a choice to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Verdict {
    /// The choice's number.
    pub choice: usize,
    /// The alternative's label.
    pub label: usize,
}
