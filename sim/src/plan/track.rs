//! What a robot drives along, by arc length.

use super::chain::Chain;
use super::circuit::Circuit;
use super::waypoint::Waypoint;
use crate::scene::PathSpec;
use nalgebra::Vector2;
use std::f64::consts::PI;

/// Radius of the circle in which a robot turns round, metres.
const TURNING_RADIUS: f64 = 0.5;

/// Length of the way on which a robot turns round, metres.
pub const TURN: f64 = 7.0 / 3.0 * PI * TURNING_RADIUS;

/// A curve to drive along.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    shape: Shape,
    /// Arc length at which it begins, metres.
    start: f64,
    /// Share of its length at which its second half begins, if that is a place of its own.
    middle: Option<f64>,
    /// Where it goes back.
    back: Option<Back>,
}

/// A turn, after which a track goes back the way it came.
#[derive(Clone, Debug, PartialEq)]
struct Back {
    /// Distance from the beginning, metres.
    after: f64,
    turn: Chain,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Circuit(Circuit),
    Chain(Chain),
}

impl Track {
    /// The track of a path that is the same for every seed; `None` for those that a seed draws, and for stations.
    pub fn fixed(path: &PathSpec) -> Option<Self> {
        let shape = match path {
            PathSpec::Circle { radius } => Shape::Circuit(Circuit::circle(*radius)),
            PathSpec::RoundedRectangle { length, width, corner_radius } => {
                Shape::Circuit(Circuit::rounded_rectangle(*length, *width, *corner_radius))
            }
            PathSpec::Waypoints { points, closed, corner_radius } => {
                let points: Vec<Vector2<f64>> = points.iter().map(|&p| p.into()).collect();
                Shape::Chain(Chain::rounded(&points, *closed, *corner_radius))
            }
            PathSpec::Lawnmower { length, width, lanes } => {
                let spacing = width / f64::from(lanes - 1);
                let points: Vec<Vector2<f64>> = (0..*lanes)
                    .flat_map(|lane| {
                        let y = f64::from(lane) * spacing - width / 2.0;
                        let from = if lane % 2 == 0 { -length / 2.0 } else { length / 2.0 };
                        [Vector2::new(from, y), Vector2::new(-from, y)]
                    })
                    .collect();
                Shape::Chain(Chain::rounded(&points, false, spacing / 2.0))
            }
            PathSpec::RandomWalk { .. }
            | PathSpec::RandomLoop(_)
            | PathSpec::InsideAndOutside(_)
            | PathSpec::Revisit(_)
            | PathSpec::Turntable { .. }
            | PathSpec::Grid { .. } => return None,
        };
        Some(Self::of(shape))
    }

    /// A circle about the origin.
    pub fn circle(radius: f64) -> Self {
        Self::of(Shape::Circuit(Circuit::circle(radius)))
    }

    /// A track along a chain.
    pub fn along(chain: Chain) -> Self {
        Self::of(Shape::Chain(chain))
    }

    /// A track along a chain of which two halves differ in length: the second begins at this share of it.
    pub fn of_halves(chain: Chain, middle: f64) -> Self {
        Self { middle: Some(middle), ..Self::along(chain) }
    }

    fn of(shape: Shape) -> Self {
        Self { shape, start: 0.0, middle: None, back: None }
    }

    /// The same track, begun so far along it, metres.
    pub fn begun_at(self, start: f64) -> Self {
        Self { start, ..self }
    }

    /// The same track, on which the robot turns round after so many metres and goes back the way it came.
    pub fn turned_back(self, after: f64) -> Self {
        let turn = Chain::turning_round(self.waypoint(after), TURNING_RADIUS);
        Self { back: Some(Back { after, turn }), ..self }
    }

    /// Length, of one lap where it is closed, metres.
    pub fn length(&self) -> f64 {
        match &self.shape {
            Shape::Circuit(circuit) => circuit.length(),
            Shape::Chain(chain) => chain.length(),
        }
    }

    /// Length of so many laps, with the turn if there is one, metres.
    pub fn driven(&self, laps: f64) -> f64 {
        laps * self.length() + if self.back.is_some() { TURN } else { 0.0 }
    }

    /// Share of so many laps at which their second half begins: above 1 where they end before the place of the track at which that is.
    pub fn middle(&self, laps: f64) -> f64 {
        self.middle.map_or(0.5, |middle| middle / laps)
    }

    /// The point `distance` metres along: any number of laps of a closed track; an open one goes straight on.
    pub fn waypoint(&self, distance: f64) -> Waypoint {
        let beyond = |back: &Back| distance - back.after;
        match &self.back {
            Some(back) if (0.0..TURN).contains(&beyond(back)) => back.turn.waypoint(beyond(back)),
            Some(back) if beyond(back) >= TURN => {
                let Waypoint { position, tangent } = self.onwards(back.after + TURN - beyond(back));
                Waypoint { position, tangent: -tangent }
            }
            _ => self.onwards(distance),
        }
    }

    /// The point `distance` metres along, without the way back.
    fn onwards(&self, distance: f64) -> Waypoint {
        let along = self.start + distance;
        match &self.shape {
            Shape::Circuit(circuit) => circuit.waypoint(along),
            Shape::Chain(chain) => chain.waypoint(along),
        }
    }

    /// Points no further than `spacing` metres apart, from its beginning to its end, and on its turn.
    pub fn samples(&self, spacing: f64) -> impl Iterator<Item = Waypoint> + '_ {
        let whole = even(self.length(), spacing).map(|along| self.onwards(along));
        let turn = move |back: &'_ Back| {
            even(TURN, spacing).map(|along| back.turn.waypoint(along)).collect::<Vec<_>>()
        };
        whole.chain(self.back.iter().flat_map(turn))
    }
}

/// Distances from 0 to a length, no further than `spacing` apart.
fn even(length: f64, spacing: f64) -> impl Iterator<Item = f64> {
    let count = (length / spacing).ceil().max(1.0) as u32;
    (0..=count).map(move |i| length * f64::from(i) / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_track_that_turns_back_comes_the_way_it_went() {
        let there = Track::circle(2.0).begun_at(1.0);
        let lap = there.length();
        let track = there.clone().turned_back(1.25 * lap);
        for along in [0.0, 3.0, 1.25 * lap] {
            let (out, back) = (track.waypoint(along), track.waypoint(2.5 * lap + TURN - along));
            assert_relative_eq!(out.position, there.waypoint(along).position, epsilon = 1e-9);
            assert_relative_eq!(out.position, back.position, epsilon = 1e-9);
            assert_relative_eq!(out.tangent, -back.tangent, epsilon = 1e-9);
        }
        assert_relative_eq!(track.driven(2.5), 2.5 * lap + TURN);
        let h = 1e-5;
        for i in 1..500 {
            let s = track.driven(2.5) * f64::from(i) / 500.0;
            let velocity = (track.waypoint(s + h).position - track.waypoint(s - h).position) / (2.0 * h);
            assert_relative_eq!(velocity, track.waypoint(s).tangent, epsilon = 1e-3);
        }
    }
}
