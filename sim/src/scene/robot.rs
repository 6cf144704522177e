//! `robot`: the path, and where the camera is mounted.

use crate::scene::rule::not_nan;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The robot's path and camera mount.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// The loop it drives, counter-clockwise, centred on the world's origin.
    #[garde(dive)]
    pub path: PathSpec,
    /// How many times it drives round; more than 1 closes the loop.
    #[garde(range(min = 0.01, max = 100.0), custom(not_nan))]
    pub laps: f64,
    /// Metres per second.
    #[garde(range(min = 0.01, max = 2.0), custom(not_nan))]
    pub speed: f64,
    /// Images taken, evenly spaced along the path, both ends included.
    #[garde(range(min = 2))]
    pub steps: u32,
    /// Where the camera is mounted.
    #[garde(dive)]
    pub camera: MountSpec,
}

/// A closed path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PathSpec {
    /// A circle.
    Circle {
        /// Radius, metres.
        #[garde(range(min = 0.2, max = 100.0), custom(not_nan))]
        radius: f64,
    },
    /// A rectangle with rounded corners, its length along x.
    RoundedRectangle {
        /// Outer extent along x, metres.
        #[garde(range(min = 0.5, max = 200.0), custom(not_nan))]
        length: f64,
        /// Outer extent along y, metres.
        #[garde(range(min = 0.5, max = 200.0), custom(not_nan))]
        width: f64,
        /// Radius of the corners, metres; at most half the shorter extent.
        #[garde(range(min = 0.2, max = 100.0), custom(not_nan), custom(at_most_half(*length, *width)))]
        corner_radius: f64,
    },
}

/// The camera's place on the robot, above its centre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct MountSpec {
    /// Height above the floor, metres.
    #[garde(range(min = 0.1, max = 5.0), custom(not_nan))]
    pub height: f64,
    /// Direction it looks, degrees to the left of straight ahead: 90 looks into the loop.
    #[garde(range(min = -180.0, max = 180.0), custom(not_nan))]
    pub yaw_deg: f64,
    /// Tilt, degrees above the horizon; negative looks down.
    #[garde(range(min = -80.0, max = 80.0), custom(not_nan))]
    pub pitch_deg: f64,
}

fn at_most_half(length: f64, width: f64) -> impl Fn(&f64, &()) -> garde::Result {
    move |radius, ()| {
        let half = length.min(width) / 2.0;
        if *radius <= half {
            Ok(())
        } else {
            Err(garde::Error::new(format!(
                "got {radius}, expected at most {half}, half the shorter of length and width"
            )))
        }
    }
}
