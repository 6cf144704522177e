//! Directions of metrics.

/// Which way a metric is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Better {
    /// Errors.
    Lower,
    /// Shares of right answers.
    Higher,
    /// Shares that a law says: the nearer, the better.
    Near(f64),
}
