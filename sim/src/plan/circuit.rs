//! Circles and rounded rectangles by arc length, driven counter-clockwise.

use super::waypoint::Waypoint;
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, PI};

/// A rectangle with rounded corners, centred on the origin; a circle is all corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circuit {
    /// Lengths of the straight parts along x and y, metres.
    straights: [f64; 2],
    /// Radius of the corners, metres.
    radius: f64,
}

impl Circuit {
    /// A circle.
    pub fn circle(radius: f64) -> Self {
        Self { straights: [0.0, 0.0], radius }
    }

    /// A rectangle of these outer extents.
    pub fn rounded_rectangle(length: f64, width: f64, corner_radius: f64) -> Self {
        Self { straights: [length - 2.0 * corner_radius, width - 2.0 * corner_radius], radius: corner_radius }
    }

    /// Length of one lap, metres.
    pub fn length(&self) -> f64 {
        2.0 * (self.straights[0] + self.straights[1]) + 2.0 * PI * self.radius
    }

    /// The point `distance` metres along the path from its start, any number of laps.
    ///
    /// A circle starts on the x axis, a rectangle in the middle of its lower long side.
    pub fn waypoint(&self, distance: f64) -> Waypoint {
        let ([along_x, along_y], radius) = (self.straights, self.radius);
        let start = along_x / 2.0;
        let mut left =
            (distance + if self.is_circle() { radius * FRAC_PI_2 } else { start }).rem_euclid(self.length());
        let quarter = radius * FRAC_PI_2;
        for side in 0..4 {
            let straight = if side % 2 == 0 { along_x } else { along_y };
            let heading = f64::from(side) * FRAC_PI_2;
            let tangent = direction(heading);
            let inward = direction(heading + FRAC_PI_2);
            let half_depth = if side % 2 == 0 { along_y / 2.0 } else { along_x / 2.0 } + radius;
            let corner = -tangent * (straight / 2.0) - inward * half_depth;
            if left < straight {
                return Waypoint { position: corner + tangent * left, tangent };
            }
            left -= straight;
            if left < quarter || side == 3 {
                let turned = left / radius;
                let center = corner + tangent * straight + inward * radius;
                let outward = direction(heading - FRAC_PI_2 + turned);
                return Waypoint {
                    position: center + outward * radius,
                    tangent: direction(heading + turned),
                };
            }
            left -= quarter;
        }
        unreachable!("the last corner takes what is left")
    }

    fn is_circle(&self) -> bool {
        self.straights == [0.0, 0.0]
    }
}

fn direction(angle: f64) -> Vector2<f64> {
    Vector2::new(libm::cos(angle), libm::sin(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn paths() -> [Circuit; 3] {
        [
            Circuit::circle(1.5),
            Circuit::rounded_rectangle(8.0, 6.0, 1.2),
            Circuit::rounded_rectangle(4.0, 2.0, 0.9),
        ]
    }

    #[test]
    fn a_path_is_walked_at_unit_speed_and_closes() {
        for path in paths() {
            let h = 1e-4;
            let lap = path.length();
            assert_relative_eq!(path.waypoint(lap).position, path.waypoint(0.0).position, epsilon = 1e-9);
            for i in 0..400 {
                let s = lap * f64::from(i) / 400.0 + 0.0123;
                let (a, b) = (path.waypoint(s - h), path.waypoint(s + h));
                let velocity = (b.position - a.position) / (2.0 * h);
                assert_relative_eq!(velocity, path.waypoint(s).tangent, epsilon = 1e-3);
            }
        }
    }

    #[test]
    fn a_path_turns_left_and_keeps_its_extents() {
        for (path, extents) in paths().into_iter().zip([[1.5, 1.5], [4.0, 3.0], [2.0, 1.0]]) {
            let points: Vec<_> =
                (0..4000).map(|i| path.waypoint(path.length() * f64::from(i) / 4000.0)).collect();
            let reach = |axis: usize| points.iter().map(|w| w.position[axis].abs()).fold(0.0, f64::max);
            assert_relative_eq!(reach(0), extents[0], epsilon = 1e-3);
            assert_relative_eq!(reach(1), extents[1], epsilon = 1e-3);
            let swept: f64 = points.iter().map(|w| w.position.perp(&w.tangent)).sum();
            assert!(swept > 0.0);
        }
        let start = Circuit::circle(1.5).waypoint(0.0);
        assert_relative_eq!(start.position, Vector2::new(1.5, 0.0), epsilon = 1e-12);
        assert_relative_eq!(start.tangent, Vector2::new(0.0, 1.0), epsilon = 1e-12);
    }
}
