//! One lap outside of a ring, counter-clockwise, and one inside, clockwise.
//!
//! Where it crosses the ring the robot turns left twice, whichever lap comes first. With the line of crossing on the x axis and
//! the lap outside first, both corners, of radius c, have their centres below it:
//!
//! ```text
//! out of the lap outside   centre at R_o - c from the origin: it turns by pi/2 + a, sin a = c / (R_o - c)
//! into the lap inside      centre at R_i + c from the origin: it turns by pi/2 - b, sin b = c / (R_i + c)
//! ```
//!
//! The other way round is the mirror image, driven backwards: the same pieces in the other order.

use super::chain::Chain;
use super::track::Track;
use super::waypoint::Waypoint;
use crate::scene::InsideAndOutsideSpec;
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, PI};

/// Radius of the corners, metres.
const CORNER: f64 = 0.5;

/// The track that crosses the ring at the angle `crossing`, as seen from the origin, radians.
pub fn track(spec: &InsideAndOutsideSpec, outside_first: bool, crossing: f64) -> Track {
    let (inner, outer) = (spec.inner_radius, spec.outer_radius);
    let a = libm::asin(CORNER / (outer - CORNER));
    let b = libm::asin(CORNER / (inner + CORNER));
    let line = (outer - CORNER) * libm::cos(a) - (inner + CORNER) * libm::cos(b);
    let [out, into] = [FRAC_PI_2 + a, FRAC_PI_2 - b].map(|turn| [1.0 / CORNER, CORNER * turn]);
    let mut pieces =
        [[1.0 / outer, 2.0 * PI * outer], out, [0.0, line], into, [-1.0 / inner, 2.0 * PI * inner]];
    let (radius, angle, tangent) = if outside_first {
        (outer, crossing - a, crossing - a + FRAC_PI_2)
    } else {
        pieces.reverse();
        (inner, crossing + b, crossing + b - FRAC_PI_2)
    };
    let from = Waypoint { position: direction(angle) * radius, tangent: direction(tangent) };
    let before_the_middle = pieces[0][1] + pieces[1][1] + line / 2.0;
    let chain = Chain::of_arcs(from, &pieces);
    let middle = before_the_middle / chain.length();
    Track::of_halves(chain, middle)
}

fn direction(angle: f64) -> Vector2<f64> {
    Vector2::new(libm::cos(angle), libm::sin(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const SPEC: InsideAndOutsideSpec =
        InsideAndOutsideSpec { inner_radius: 1.6, outer_radius: 4.4, clearance: 0.2 };

    #[test]
    fn laps_are_whole_and_the_crossing_is_where_it_should_be() {
        for (outside_first, radii) in [(true, [4.4, 1.6]), (false, [1.6, 4.4])] {
            let track = track(&SPEC, outside_first, 0.7);
            let [first, second] = radii;
            for i in 0..=100 {
                let share = f64::from(i) / 100.0;
                let lap = track.waypoint(share * 2.0 * PI * first).position;
                assert_relative_eq!(lap.norm(), first, epsilon = 1e-9);
                let from_the_end = track.length() - share * 2.0 * PI * second;
                assert_relative_eq!(track.waypoint(from_the_end).position.norm(), second, epsilon = 1e-9);
            }
            let middle = track.waypoint(track.middle(1.0) * track.length());
            assert_relative_eq!(libm::atan2(middle.position.y, middle.position.x), 0.7, epsilon = 1e-9);
            let inwards = middle.tangent.dot(&-middle.position.normalize());
            assert_relative_eq!(inwards, if outside_first { 1.0 } else { -1.0 }, epsilon = 1e-9);
            let left = |at: f64| {
                let Waypoint { position, tangent } = track.waypoint(at);
                position.dot(&Vector2::new(-tangent.y, tangent.x)) / position.norm()
            };
            let [on_first, on_second] = [left(1.0), left(track.length() - 1.0)];
            let outwards = if outside_first { -1.0 } else { 1.0 };
            assert_relative_eq!(on_first, outwards, epsilon = 1e-9);
            assert_relative_eq!(on_second, -outwards, epsilon = 1e-9);
        }
    }
}
