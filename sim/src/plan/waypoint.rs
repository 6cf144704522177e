//! A point on a way.

use nalgebra::Vector2;

/// A point on a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Where, world frame, metres.
    pub position: Vector2<f64>,
    /// Unit vector along the way.
    pub tangent: Vector2<f64>,
}
