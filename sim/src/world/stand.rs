//! Stands: tables and pedestals, what objects stand on.

use crate::scene::{PathSpec, RobotSpec, SurfaceSpec};
use nalgebra::Vector2;

/// A level surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Centre of its top, world frame, metres.
    pub center: Vector2<f64>,
    /// Height of its top, metres.
    pub height: f64,
    /// Outline of its top.
    pub outline: Outline,
}

/// Outline of a stand's top, about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A circle.
    Disc {
        /// Radius, metres.
        radius: f64,
    },
    /// A rectangle along the world's axes.
    Rectangle {
        /// Half its extent along x and y, metres.
        half_extents: [f64; 2],
    },
}

impl Outline {
    /// Half its extent along x and y, metres.
    pub fn half_extents(&self) -> [f64; 2] {
        match *self {
            Outline::Disc { radius } => [radius; 2],
            Outline::Rectangle { half_extents } => half_extents,
        }
    }
}

impl Stand {
    /// Whether a point, world frame, lies above or below its top.
    pub fn spans(&self, point: &Vector2<f64>) -> bool {
        let from_center = point - self.center;
        match self.outline {
            Outline::Disc { radius } => from_center.norm() <= radius,
            Outline::Rectangle { half_extents: [x, y] } => {
                from_center.x.abs() <= x && from_center.y.abs() <= y
            }
        }
    }
}

impl SurfaceSpec {
    /// The stands of a world for this many objects; a table is one, pedestals are one an object.
    pub fn stands(&self, robot: &RobotSpec, objects: usize) -> Vec<Stand> {
        let center = Vector2::zeros();
        match *self {
            SurfaceSpec::RoundTable { radius, height } => {
                vec![Stand { center, height, outline: Outline::Disc { radius } }]
            }
            SurfaceSpec::RectangularTable { length, width, height } => {
                let outline = Outline::Rectangle { half_extents: [length / 2.0, width / 2.0] };
                vec![Stand { center, height, outline }]
            }
            SurfaceSpec::Pedestals { radius, height, offset } => (0..objects)
                .map(|i| {
                    let share = (i as f64 + 0.5) / objects as f64;
                    let center = beside(&robot.path, share, looks_left(robot), offset);
                    Stand { center, height, outline: Outline::Disc { radius } }
                })
                .collect(),
        }
    }

    /// What it is called in messages.
    pub fn name(&self) -> &'static str {
        match self {
            SurfaceSpec::RoundTable { .. } => "round table",
            SurfaceSpec::RectangularTable { .. } => "rectangular table",
            SurfaceSpec::Pedestals { .. } => "pedestals",
        }
    }
}

fn looks_left(robot: &RobotSpec) -> bool {
    robot.camera.yaw_deg >= 0.0
}

fn beside(path: &PathSpec, share: f64, left: bool, offset: f64) -> Vector2<f64> {
    let waypoint = path.waypoint(share * path.length());
    let to_the_left = Vector2::new(-waypoint.tangent.y, waypoint.tangent.x);
    waypoint.position + to_the_left * if left { offset } else { -offset }
}
