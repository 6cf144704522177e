//! How many hypotheses are kept, and which.

/// Bounds of time and memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Most hypotheses.
    pub hypotheses: usize,
    /// Share of all mass below which a hypothesis is dropped.
    pub least_weight: f64,
    /// When two hypotheses are one; never where absent.
    pub merging: Option<Merging>,
}

/// Two hypotheses are one once what tells them apart lies behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merging {
    /// Newest verdicts that must be the same.
    pub window: usize,
    /// Most deviations between their newest poses.
    pub distance: f64,
}

impl Default for Limits {
    /// Chosen on worlds that `examples/association generated` draws.
    fn default() -> Self {
        Self { hypotheses: 256, least_weight: 1e-4, merging: Some(Merging { window: 8, distance: 0.3 }) }
    }
}

impl Limits {
    /// Nothing is dropped or merged: the weights are those of all assignments.
    pub fn exact() -> Self {
        Self { hypotheses: usize::MAX, least_weight: 0.0, merging: None }
    }
}
