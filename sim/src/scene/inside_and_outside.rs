//! `robot.path.inside_and_outside`: one lap outside of what stands in a ring, and one inside.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// Least difference between the radii, metres: two corners of half a metre, and some way between.
const APART: f64 = 1.2;

/// A lap outside of a ring and one inside it, round the world's origin: counter-clockwise outside and clockwise inside, so that
/// the ring is on the left. The seed draws which lap comes first, and where the robot crosses the ring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct InsideAndOutsideSpec {
    /// Radius of the lap inside, metres.
    #[garde(range(min = 0.5, max = 100.0), custom(not_nan))]
    pub inner_radius: f64,
    /// Radius of the lap outside, metres; at least 1.2 m more.
    #[garde(range(min = 1.0, max = 100.0), custom(not_nan), custom(outside(self.inner_radius)))]
    pub outer_radius: f64,
    /// Least distance of the robot's body from anything, metres.
    #[garde(range(min = 0.0, max = 5.0), custom(not_nan))]
    pub clearance: f64,
}

fn outside(inner: f64) -> impl Fn(&f64, &()) -> garde::Result {
    move |outer, ()| {
        let least = inner + APART;
        if *outer < least {
            return Err(garde::Error::new(format!(
                "got {outer}, expected at least {least:.2}: {APART} m more than inner_radius, to cross between the laps"
            )));
        }
        Ok(())
    }
}
