//! What the process is told of objects as such.

use super::reduced::COMPONENTS;

/// What [`Hyperparameters::fit`] fits by marginal likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hyperparameters {
    /// Concentration of the kernel over the azimuth; about one over its squared length in radians.
    pub kappa: f64,
    /// Standard deviation of each component over objects and azimuths.
    pub signal: [f64; COMPONENTS],
    /// Standard deviation of each component's noise.
    pub noise: [f64; COMPONENTS],
}

impl Hyperparameters {
    /// Placeholders, not fitted yet: to be replaced by what `bench calibrate scenes/sparse_loop.yaml 40` prints.
    pub const FITTED: Self = Self { kappa: 3.0, signal: [0.1; COMPONENTS], noise: [0.05; COMPONENTS] };
}
