//! Closed paths by arc length, driven counter-clockwise.

use crate::scene::PathSpec;
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, PI};

/// A point on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Where, world frame, metres.
    pub position: Vector2<f64>,
    /// Unit vector along the path.
    pub tangent: Vector2<f64>,
}

impl PathSpec {
    /// Extent from the centre along x and y, metres.
    pub fn half_extents(&self) -> [f64; 2] {
        match *self {
            PathSpec::Circle { radius } => [radius, radius],
            PathSpec::RoundedRectangle { length, width, .. } => [length / 2.0, width / 2.0],
        }
    }

    /// Length of one lap, metres.
    pub fn length(&self) -> f64 {
        let (straights, radius) = self.straights();
        2.0 * (straights[0] + straights[1]) + 2.0 * PI * radius
    }

    /// The point `distance` metres along the path from its start, any number of laps.
    ///
    /// A circle starts on the x axis, a rectangle in the middle of its lower long side.
    pub fn waypoint(&self, distance: f64) -> Waypoint {
        let ([along_x, along_y], radius) = self.straights();
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

    /// Distance from the path's nearest point to the origin, metres.
    pub fn clearance_of_disc(&self) -> f64 {
        let [x, y] = self.half_extents();
        x.min(y)
    }

    /// Distance from the path's nearest point to a centred rectangle with these half extents, metres; 0 where
    /// the path crosses it.
    pub fn clearance_of_rectangle(&self, half_length: f64, half_width: f64) -> f64 {
        let samples = 4096;
        (0..samples)
            .map(|i| {
                let p = self.waypoint(self.length() * f64::from(i) / f64::from(samples)).position;
                let beside = Vector2::new(p.x.abs() - half_length, p.y.abs() - half_width);
                beside.map(|gap| gap.max(0.0)).norm()
            })
            .fold(f64::INFINITY, f64::min)
    }

    fn is_circle(&self) -> bool {
        matches!(self, PathSpec::Circle { .. })
    }

    /// Lengths of the straight parts along x and y, and the radius of the corners; a circle is all corner.
    fn straights(&self) -> ([f64; 2], f64) {
        match *self {
            PathSpec::Circle { radius } => ([0.0, 0.0], radius),
            PathSpec::RoundedRectangle { length, width, corner_radius } => {
                ([length - 2.0 * corner_radius, width - 2.0 * corner_radius], corner_radius)
            }
        }
    }
}

fn direction(angle: f64) -> Vector2<f64> {
    Vector2::new(libm::cos(angle), libm::sin(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn paths() -> [PathSpec; 3] {
        [
            PathSpec::Circle { radius: 1.5 },
            PathSpec::RoundedRectangle { length: 8.0, width: 6.0, corner_radius: 1.2 },
            PathSpec::RoundedRectangle { length: 4.0, width: 2.0, corner_radius: 1.0 },
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
        for path in paths() {
            let points: Vec<_> =
                (0..4000).map(|i| path.waypoint(path.length() * f64::from(i) / 4000.0)).collect();
            let reach = |axis: usize| points.iter().map(|w| w.position[axis].abs()).fold(0.0, f64::max);
            assert_relative_eq!(reach(0), path.half_extents()[0], epsilon = 1e-3);
            assert_relative_eq!(reach(1), path.half_extents()[1], epsilon = 1e-3);
            let swept: f64 = points.iter().map(|w| w.position.perp(&w.tangent)).sum();
            assert!(swept > 0.0);
        }
        let start = PathSpec::Circle { radius: 1.5 }.waypoint(0.0);
        assert_relative_eq!(start.position, Vector2::new(1.5, 0.0), epsilon = 1e-12);
        assert_relative_eq!(start.tangent, Vector2::new(0.0, 1.0), epsilon = 1e-12);
    }

    #[test]
    fn clearances_are_distances() {
        let [circle, rectangle, _] = paths();
        assert_relative_eq!(circle.clearance_of_disc(), 1.5);
        assert_relative_eq!(circle.clearance_of_rectangle(0.3, 0.4), 1.0, epsilon = 1e-3);
        assert_relative_eq!(rectangle.clearance_of_rectangle(1.0, 1.0), 2.0, epsilon = 1e-3);
        assert_relative_eq!(circle.clearance_of_rectangle(2.0, 0.4), 0.0);
    }
}
