//! What was done, what was given up, and why it cannot go on.

use super::estimator::Unsolved;

/// Why association cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AssociationError {
    /// No hypothesis has an estimate any more.
    #[error("no hypothesis is left: {0}")]
    Unsolved(#[from] Unsolved),
    /// A choice has no alternative that any hypothesis allows.
    #[error("no alternative of choice {0} is possible; give it one of clutter or of nothing")]
    Impossible(usize),
}

/// What has been given up so far, as shares of the mass at the time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenUp {
    /// Of hypotheses that were dropped: bounds how far a weight is off by that.
    pub dropped: f64,
    /// Of hypotheses merged into others, whose estimate is then another's.
    pub merged: f64,
}

/// What happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Choices that left one hypothesis from one.
    pub plain: usize,
    /// Estimates brought up to date.
    pub updates: usize,
    /// Continuations weighed.
    pub weighed: usize,
    /// Most hypotheses at a time.
    pub most: usize,
}
