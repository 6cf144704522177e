//! `robot.path.revisit`: two passes of one place, from two sides.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// Two straight passes of the world's origin, which is on the left, and a way round between them. The way round goes clockwise, its
/// shape and the first pass's direction are others for each seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct RevisitSpec {
    /// Distance of both passes from the origin at their middle, metres.
    #[garde(range(min = 0.5, max = 50.0), custom(not_nan))]
    pub distance: f64,
    /// Length of a pass, metres; half to four times the distance.
    #[garde(range(min = 0.25, max = 200.0), custom(not_nan), custom(half_to_four_times(self.distance)))]
    pub pass: f64,
    /// By how much the second pass is the first one turned about the origin, degrees.
    #[garde(range(min = 0.0, max = 180.0), custom(not_nan))]
    pub angle_deg: f64,
    /// Length of the way between the passes, metres: the same whatever the angle.
    #[garde(range(min = 1.0, max = 2000.0), custom(not_nan))]
    pub detour: f64,
}

fn half_to_four_times(distance: f64) -> impl Fn(&f64, &()) -> garde::Result {
    move |pass, ()| {
        let (low, high) = (distance / 2.0, 4.0 * distance);
        if *pass < low || *pass > high {
            return Err(garde::Error::new(format!(
                "got {pass}, expected {low} to {high}: half the distance to four times it"
            )));
        }
        Ok(())
    }
}
