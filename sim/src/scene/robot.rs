//! `robot`: the path, and where the camera is mounted.

use crate::scene::path::PathSpec;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// The robot's path and camera mount.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Where it goes.
    #[garde(dive)]
    pub path: PathSpec,
    /// How many times it drives round a closed path; more than 1 closes the loop. Open paths are driven once at most.
    #[serde(default = "once")]
    #[garde(range(min = 0.01, max = 100.0), custom(not_nan), custom(laps_of(&self.path)))]
    pub laps: f64,
    /// After so many laps it turns round, in a circle of half a metre, and drives the other way; closed paths only. It drives on the
    /// same way round where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(inner(range(min = 0.01, max = 100.0), custom(not_nan)), custom(turn_of(&self.path, self.laps)))]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub reverse_after: Option<f64>,
    /// After so many laps it is carried, between two images, to anywhere on the path, drawn from the seed; closed paths only. Odometry
    /// tells nothing of where to. It is left to drive on where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(inner(range(min = 0.01, max = 100.0), custom(not_nan)), custom(carried_of(self)))]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub carried_after: Option<f64>,
    /// Metres per second, of what drives.
    #[serde(default = "walking_pace")]
    #[garde(range(min = 0.01, max = 2.0), custom(not_nan))]
    pub speed: f64,
    /// Images taken, evenly spaced along the path, both ends included. `turntable` and `grid` say themselves where images
    /// are taken.
    #[serde(default)]
    #[garde(inner(range(min = 2)), custom(steps_of(&self.path)))]
    #[schemars(range(min = 2))]
    pub steps: Option<u32>,
    /// Whether it starts at the beginning of a closed path or anywhere on it, by the seed; open paths have one beginning.
    #[serde(default, skip_serializing_if = "StartSpec::is_default")]
    #[garde(skip)]
    pub start: StartSpec,
    /// Where the camera is mounted.
    #[garde(dive)]
    pub camera: MountSpec,
    /// Carries the camera by hand instead: it sways in all six degrees of freedom.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive, custom(hand_of(&self.path, self.camera.height)))]
    pub handheld: Option<HandheldSpec>,
}

/// Where a closed path begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StartSpec {
    /// At its beginning.
    #[default]
    Beginning,
    /// Anywhere on it, drawn from the seed.
    Anywhere,
}

impl StartSpec {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
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

/// How a hand sways about the mount: slow sinusoids in every degree of freedom, with phases of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct HandheldSpec {
    /// Amplitude along each axis, metres.
    #[garde(range(min = 0.0, max = 0.5), custom(not_nan))]
    pub sway: f64,
    /// Amplitude about each axis, degrees.
    #[garde(range(min = 0.0, max = 30.0), custom(not_nan))]
    pub tilt_deg: f64,
    /// Seconds of one swing, about; at least.
    #[garde(range(min = 0.5, max = 60.0), custom(not_nan))]
    pub period: f64,
}

fn once() -> f64 {
    1.0
}

fn walking_pace() -> f64 {
    0.5
}

fn hand_of(path: &PathSpec, height: f64) -> impl Fn(&Option<HandheldSpec>, &()) -> garde::Result {
    move |hand, ()| match hand {
        Some(_) if path.stations() => {
            Err(garde::Error::new("cameras of a turntable or a grid do not sway; leave `handheld` out"))
        }
        Some(hand) if hand.sway >= height => Err(garde::Error::new(format!(
            "a sway of {} m would take the camera, {height} m high, below the floor",
            hand.sway
        ))),
        _ => Ok(()),
    }
}

fn laps_of(path: &PathSpec) -> impl Fn(&f64, &()) -> garde::Result {
    move |laps, ()| {
        if path.is_closed() || *laps <= 1.0 {
            return Ok(());
        }
        Err(garde::Error::new(format!(
            "got {laps}, expected at most 1: the path does not end where it begins"
        )))
    }
}

fn turn_of(path: &PathSpec, laps: f64) -> impl Fn(&Option<f64>, &()) -> garde::Result {
    move |after, ()| match after {
        Some(_) if !path.is_closed() => Err(garde::Error::new(
            "this path does not end where it begins; leave `reverse_after` out or choose a closed path",
        )),
        Some(after) if *after >= laps => Err(garde::Error::new(format!(
            "got {after}, expected less than robot.laps, {laps}: nothing would be driven after the turn"
        ))),
        _ => Ok(()),
    }
}

fn carried_of(robot: &RobotSpec) -> impl Fn(&Option<f64>, &()) -> garde::Result {
    move |after, ()| match after {
        Some(_) if !robot.path.is_closed() => Err(garde::Error::new(
            "this path does not end where it begins; leave `carried_after` out or choose a closed path",
        )),
        Some(_) if robot.reverse_after.is_some() => {
            Err(garde::Error::new("a robot that turns round is not carried; leave `reverse_after` out"))
        }
        Some(_) if robot.handheld.is_some() => {
            Err(garde::Error::new("what a hand holds is not set down on the floor; leave `handheld` out"))
        }
        Some(after) if *after >= robot.laps => Err(garde::Error::new(format!(
            "got {after}, expected less than robot.laps, {}: nothing would be driven where it is set down",
            robot.laps
        ))),
        _ => Ok(()),
    }
}

fn steps_of(path: &PathSpec) -> impl Fn(&Option<u32>, &()) -> garde::Result {
    move |steps, ()| match (path.stations(), steps) {
        (false, None) => Err(garde::Error::new("missing; expected the number of images along the path")),
        (true, Some(_)) => {
            Err(garde::Error::new("this path says itself where images are taken; leave `steps` out"))
        }
        _ => Ok(()),
    }
}
