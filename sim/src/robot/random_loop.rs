//! Random loops that touch nothing.

use super::STRIDE;
use crate::error::SimError;
use crate::plan::body;
use crate::plan::ground::Ground;
use crate::plan::random_loop::{Shape, chain};
use crate::plan::track::Track;
use crate::scene::{Direction, RandomLoopSpec};
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Loops tried before giving up.
const TRIES: usize = 200;
/// Least radius of a curve, metres.
const SHARPEST: f64 = 0.4;

/// Draws a loop that keeps the robot's body clear of everything.
pub fn draw(spec: &RandomLoopSpec, ground: &Ground, stream: &mut Stream) -> Result<Track, SimError> {
    let margin = body::RADIUS + spec.clearance;
    (0..TRIES)
        .find_map(|_| {
            let chain = chain(spec, &shape(spec, stream));
            if chain.least_radius() < SHARPEST {
                return None;
            }
            let track = Track::along(chain);
            let (gap, _) = ground.narrowest(track.samples(STRIDE).map(|waypoint| waypoint.position))?;
            (gap >= margin).then_some(track)
        })
        .ok_or(SimError::NoLoop { clearance: spec.clearance, sharpest: SHARPEST })
}

fn shape(spec: &RandomLoopSpec, stream: &mut Stream) -> Shape {
    // From above 0, so that their sum is.
    let weights = std::array::from_fn(|_| stream.uniform(0.05, 1.0));
    let phases = std::array::from_fn(|_| stream.uniform(-PI, PI));
    let start = stream.uniform(-PI, PI);
    let clockwise = stream.chance(0.5) && spec.direction == Direction::Either;
    Shape { weights, phases, start, clockwise }
}
