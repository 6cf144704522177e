//! Two passes of one place, drawn for a seed.

use crate::error::SimError;
use crate::plan::body;
use crate::plan::chain::Chain;
use crate::plan::ground::Ground;
use crate::plan::revisit::{FACTOR, Revisit};
use crate::plan::track::Track;
use crate::scene::RevisitSpec;
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Distance between the places of a track that are looked at, metres.
const STRIDE: f64 = 0.05;

/// Draws the direction of the first pass, then the shape of the way round: both are the same for all angles between the passes.
pub fn draw(spec: &RevisitSpec, stream: &mut Stream) -> Result<Chain, SimError> {
    let turn = stream.uniform(-PI, PI);
    let factors = std::array::from_fn(|_| stream.uniform(FACTOR[0], FACTOR[1]));
    let revisit = Revisit::new(spec);
    let no_detour = || SimError::NoDetour { detour: spec.detour, least: revisit.least_detour() };
    revisit.chain(turn, &factors).ok_or_else(no_detour)
}

/// Whether a drawn track keeps the robot's body clear of everything.
pub fn keeps_clear(track: &Track, ground: &Ground) -> Result<(), SimError> {
    let gaps =
        track.samples(STRIDE).map(|waypoint| (ground.clearance(&waypoint.position), waypoint.position));
    match gaps.min_by(|(a, _), (b, _)| a.total_cmp(b)) {
        Some((gap, at)) if gap < body::RADIUS => Err(SimError::BlockedPath { at: at.into(), gap }),
        _ => Ok(()),
    }
}
