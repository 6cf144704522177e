//! Two passes of one place, drawn for a seed.

use crate::error::SimError;
use crate::plan::chain::Chain;
use crate::plan::revisit::{FACTOR, Revisit};
use crate::scene::RevisitSpec;
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Draws the direction of the first pass, then the shape of the way round: both are the same for all angles between the passes.
pub fn draw(spec: &RevisitSpec, stream: &mut Stream) -> Result<Chain, SimError> {
    let turn = stream.uniform(-PI, PI);
    let factors = std::array::from_fn(|_| stream.uniform(FACTOR[0], FACTOR[1]));
    let revisit = Revisit::new(spec);
    let no_detour = || SimError::NoDetour { detour: spec.detour, least: revisit.least_detour() };
    revisit.chain(turn, &factors).ok_or_else(no_detour)
}
