//! What an update is asked for, and what it did.

/// When work is worth its while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Distance, in whitened numbers, of a factor's residual from that of its linearisation, from which on it is linearised anew.
    pub relinearization: f64,
    /// Change of a coordinate, radians, metres or deviations of a latent, below which what depends on it is left.
    pub propagation: f64,
    /// Most iterations of one update whose step is taken.
    pub iterations: usize,
    /// Most whose step is refused.
    pub rejections: usize,
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// Factors linearised anew.
    pub relinearized: usize,
    /// Variables solved for.
    pub solved: usize,
    /// Whether some factors still wait to be linearised anew, or some variables are damped: the next update goes on.
    pub is_unfinished: bool,
}
