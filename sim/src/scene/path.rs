//! `robot.path`: where the robot goes, or where images are taken.

use crate::scene::inside_and_outside::InsideAndOutsideSpec;
use crate::scene::random_loop::RandomLoopSpec;
use crate::scene::revisit::RevisitSpec;
use crate::scene::rule::{Interval, interval_within};
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// Where the robot goes. Circles, rectangles and lawnmowers are centred on the world's origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PathSpec {
    /// A circle, counter-clockwise.
    Circle {
        /// Radius, metres.
        #[garde(range(min = 0.2, max = 100.0), custom(not_nan))]
        radius: f64,
    },
    /// A rectangle with rounded corners, its length along x, counter-clockwise.
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
    /// From point to point, corners rounded.
    Waypoints {
        /// The points `[x, y]`, metres.
        #[garde(length(min = 2, max = 1000), custom(drivable(*closed)))]
        points: Vec<[f64; 2]>,
        /// Whether it goes on from the last point to the first.
        #[serde(default)]
        #[garde(custom(three_close(points.len())))]
        closed: bool,
        /// Radius of the corners, metres; smaller where points are close.
        #[garde(range(min = 0.2, max = 10.0), custom(not_nan))]
        corner_radius: f64,
    },
    /// Lanes along x, to and fro, from negative to positive y.
    Lawnmower {
        /// Extent along x, metres.
        #[garde(range(min = 0.5, max = 200.0), custom(not_nan))]
        length: f64,
        /// Extent along y, metres.
        #[garde(range(min = 0.5, max = 200.0), custom(not_nan))]
        width: f64,
        /// How many.
        #[garde(range(min = 2, max = 200), custom(lanes_apart(*length, *width)))]
        lanes: u32,
    },
    /// Straight legs in random directions, clear of furniture and walls; another walk for each seed.
    RandomWalk {
        /// How many.
        #[garde(range(min = 1, max = 500))]
        legs: u32,
        /// Lengths, metres, drawn evenly.
        #[garde(custom(interval_within(0.5, 50.0)))]
        leg_length: Interval,
        /// Least distance of the robot's body from anything, metres.
        #[garde(range(min = 0.0, max = 5.0), custom(not_nan))]
        clearance: f64,
    },
    /// Round the middle of the room on a smooth closed loop; another loop for each seed.
    RandomLoop(#[garde(dive)] RandomLoopSpec),
    /// Round what stands in a ring twice, outside and inside, so that it is seen from both sides; another crossing for each seed.
    InsideAndOutside(#[garde(dive)] InsideAndOutsideSpec),
    /// Past one place twice, from two sides, with a long way between where it is out of sight; another way for each seed.
    Revisit(#[garde(dive)] RevisitSpec),
    /// BigBIRD's protocol: the camera at each elevation takes an image at each angle of a table that turns once. Expects
    /// the one object in the middle of a round table.
    Turntable {
        /// Distance of the camera from the object's place, metres.
        #[garde(range(min = 0.2, max = 10.0), custom(not_nan))]
        distance: f64,
        /// Elevations of the cameras, degrees.
        #[garde(length(min = 1, max = 20), inner(range(min = 0.0, max = 89.0), custom(not_nan)))]
        elevations_deg: Vec<f64>,
        /// Evenly spaced angles in a turn.
        #[garde(range(min = 1, max = 3600))]
        angles: u32,
    },
    /// The Active Vision protocol: at every free point of a square grid, images in evenly spaced directions.
    Grid {
        /// Between neighbouring points, metres.
        #[garde(range(min = 0.05, max = 10.0), custom(not_nan))]
        spacing: f64,
        /// Directions at each point.
        #[garde(range(min = 1, max = 360))]
        headings: u32,
        /// Least distance of the robot's body from anything, metres.
        #[garde(range(min = 0.0, max = 5.0), custom(not_nan))]
        clearance: f64,
    },
}

impl PathSpec {
    /// Whether it ends where it begins.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Circle { .. } | Self::RoundedRectangle { .. } | Self::RandomLoop(_) => true,
            Self::Waypoints { closed, .. } => *closed,
            _ => false,
        }
    }

    /// Whether images are taken at given places, between which nothing drives.
    pub fn stations(&self) -> bool {
        matches!(self, Self::Turntable { .. } | Self::Grid { .. })
    }
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

/// Distance below which two points are one, metres.
const APART: f64 = 0.05;

/// Sharper turns are not driven, radians.
pub const SHARPEST: f64 = 0.75 * std::f64::consts::PI;

fn drivable(closed: bool) -> impl Fn(&Vec<[f64; 2]>, &()) -> garde::Result {
    move |points, ()| finite_and_apart(points, closed)
}

fn finite_and_apart(points: &[[f64; 2]], closed: bool) -> garde::Result {
    if points.iter().flatten().any(|x| !x.is_finite() || x.abs() > 500.0) {
        return Err(garde::Error::new("expected coordinates within 500 m of the origin"));
    }
    let count = points.len();
    let lines = if closed { count } else { count.saturating_sub(1) };
    let line = |i: usize| {
        let (a, b) = (points[i % count], points[(i + 1) % count]);
        [b[0] - a[0], b[1] - a[1]]
    };
    if let Some(i) = (0..lines).find(|&i| libm::hypot(line(i)[0], line(i)[1]) < APART) {
        let next = (i + 1) % count;
        return Err(garde::Error::new(format!(
            "points {i} and {next} are closer than {APART} m: leave one out"
        )));
    }
    let turn = |i: usize| {
        let ([ax, ay], [bx, by]) = (line(i), line(i + 1));
        libm::atan2(ax * by - ay * bx, ax * bx + ay * by).abs()
    };
    let corners = if closed { count } else { count.saturating_sub(2) };
    match (0..corners).find(|&i| turn(i) > SHARPEST) {
        None => Ok(()),
        Some(i) => Err(garde::Error::new(format!(
            "at point {} the path turns by {:.0} degrees, expected at most {:.0}: put a point between",
            (i + 1) % count,
            turn(i).to_degrees(),
            SHARPEST.to_degrees()
        ))),
    }
}

fn three_close(points: usize) -> impl Fn(&bool, &()) -> garde::Result {
    move |closed, ()| {
        if *closed && points < 3 {
            return Err(garde::Error::new(format!("got {points} points, a closed path needs three")));
        }
        Ok(())
    }
}

fn lanes_apart(length: f64, width: f64) -> impl Fn(&u32, &()) -> garde::Result {
    move |lanes, ()| {
        let spacing = width / f64::from(lanes.saturating_sub(1).max(1));
        if spacing < 0.4 - 1e-9 || spacing > length {
            return Err(garde::Error::new(format!(
                "lanes would be {spacing:.2} m apart, expected 0.4 m to the path's length ({length} m)"
            )));
        }
        Ok(())
    }
}
