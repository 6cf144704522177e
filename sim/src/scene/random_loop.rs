//! `robot.path.random_loop`: a loop round the world's origin, another one for each seed.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// A smooth closed loop round the world's origin, clear of furniture and walls. The seed draws its shape and where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct RandomLoopSpec {
    /// Mean distance from the origin, metres.
    #[garde(range(min = 0.5, max = 100.0), custom(not_nan))]
    pub radius: f64,
    /// Greatest deviation of that distance, as a share of it; 0 is a circle.
    #[garde(range(min = 0.0, max = 0.5), custom(not_nan))]
    pub amplitude: f64,
    /// Which way round.
    #[serde(default, skip_serializing_if = "Direction::is_default")]
    #[garde(skip)]
    pub direction: Direction,
    /// Least distance of the robot's body from anything, metres.
    #[garde(range(min = 0.0, max = 5.0), custom(not_nan))]
    pub clearance: f64,
}

/// Which way round a loop is driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Counter-clockwise: a camera that looks left looks into the loop.
    #[default]
    CounterClockwise,
    /// Counter-clockwise or clockwise, drawn from the seed.
    Either,
}

impl Direction {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
