//! The robot's body: an upright cylinder on the floor.

/// Radius, metres.
pub const RADIUS: f64 = 0.2;
/// Height, metres.
pub const HEIGHT: f64 = 0.4;
/// Mass, kilograms.
pub const MASS: f64 = 10.0;
