//! What a robot drives along, by arc length.

use super::chain::Chain;
use super::circuit::Circuit;
use super::waypoint::Waypoint;
use crate::scene::PathSpec;
use nalgebra::Vector2;

/// A curve to drive along.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    shape: Shape,
    /// Arc length at which it begins, metres.
    start: f64,
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
            | PathSpec::Revisit(_)
            | PathSpec::Turntable { .. }
            | PathSpec::Grid { .. } => return None,
        };
        Some(Self { shape, start: 0.0 })
    }

    /// A track along a chain.
    pub fn along(chain: Chain) -> Self {
        Self { shape: Shape::Chain(chain), start: 0.0 }
    }

    /// The same track, begun so far along it, metres.
    pub fn begun_at(self, start: f64) -> Self {
        Self { start, ..self }
    }

    /// Length, of one lap where it is closed, metres.
    pub fn length(&self) -> f64 {
        match &self.shape {
            Shape::Circuit(circuit) => circuit.length(),
            Shape::Chain(chain) => chain.length(),
        }
    }

    /// The point `distance` metres along: any number of laps of a closed track; an open one goes straight on.
    pub fn waypoint(&self, distance: f64) -> Waypoint {
        let along = self.start + distance;
        match &self.shape {
            Shape::Circuit(circuit) => circuit.waypoint(along),
            Shape::Chain(chain) => chain.waypoint(along),
        }
    }

    /// Points no further than `spacing` metres apart, from its beginning to its end.
    pub fn samples(&self, spacing: f64) -> impl Iterator<Item = Waypoint> + '_ {
        let count = (self.length() / spacing).ceil().max(1.0) as u32;
        (0..=count).map(move |i| self.waypoint(self.length() * f64::from(i) / f64::from(count)))
    }
}
