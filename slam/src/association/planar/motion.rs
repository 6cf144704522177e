//! Motions of the plane.

use super::{rotation, wrapped};
use nalgebra::{DVector, Vector2, Vector3};

/// A pose relative to another, or in the world: metres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Forward.
    pub x: f64,
    /// To the left.
    pub y: f64,
    /// Counter-clockwise.
    pub heading: f64,
}

impl Motion {
    /// From its three numbers.
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self { x, y, heading }
    }

    /// From the value of a planar pose.
    pub fn from_value(value: &DVector<f64>) -> Option<Self> {
        match value.as_slice() {
            [x, y, heading] => Some(Self::new(*x, *y, *heading)),
            _ => None,
        }
    }

    /// As the value of a planar pose.
    pub fn to_value(self) -> crate::variable::Value {
        crate::variable::Value::Vector(DVector::from_column_slice(&[self.x, self.y, self.heading]))
    }

    /// Where a motion from here leads.
    pub fn then(self, motion: Motion) -> Self {
        let moved = self.point(Vector2::new(motion.x, motion.y));
        Self::new(moved.x, moved.y, self.heading + motion.heading)
    }

    /// A point of this frame, in the frame that this one is told in.
    pub fn point(self, point: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(self.x, self.y) + rotation(self.heading).tr_mul(&point)
    }

    /// A point of the frame that this one is told in, in this frame.
    pub fn seen(self, point: Vector2<f64>) -> Vector2<f64> {
        rotation(self.heading) * (point - Vector2::new(self.x, self.y))
    }

    /// The motion from here to there.
    pub fn to(self, there: Motion) -> Self {
        let seen = self.seen(Vector2::new(there.x, there.y));
        Self::new(seen.x, seen.y, wrapped(there.heading - self.heading))
    }

    pub(super) fn vector(self) -> Vector3<f64> {
        Vector3::new(self.x, self.y, self.heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_motion_and_the_way_to_where_it_leads_are_one() {
        let (here, motion) = (Motion::new(1.0, -2.0, 2.5), Motion::new(0.3, 0.7, 1.9));
        let back = here.to(here.then(motion));
        assert_relative_eq!(back.vector(), motion.vector(), epsilon = 1e-14);
        let point = Vector2::new(4.0, 5.0);
        assert_relative_eq!(here.seen(here.point(point)), point, epsilon = 1e-14);
    }
}
