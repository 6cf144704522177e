//! A lap outside of a ring and one inside, drawn for a seed.

use super::STRIDE;
use crate::error::SimError;
use crate::plan::body;
use crate::plan::ground::Ground;
use crate::plan::inside_and_outside::track;
use crate::plan::track::Track;
use crate::scene::InsideAndOutsideSpec;
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Places to cross at that are tried before giving up.
const TRIES: usize = 1000;

/// Draws which lap comes first, then where to cross: where the robot's body keeps clear of everything.
pub fn draw(spec: &InsideAndOutsideSpec, ground: &Ground, stream: &mut Stream) -> Result<Track, SimError> {
    let margin = body::RADIUS + spec.clearance;
    let outside_first = stream.chance(0.5);
    (0..TRIES)
        .map(|_| track(spec, outside_first, stream.uniform(-PI, PI)))
        .find(|track| {
            let points = track.samples(STRIDE).map(|waypoint| waypoint.position);
            ground.narrowest(points).is_some_and(|(gap, _)| gap >= margin)
        })
        .ok_or(SimError::NoCrossing { clearance: spec.clearance })
}
