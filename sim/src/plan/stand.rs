//! Stands: tops of tables, pedestals and boards, what objects stand on.

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
    /// Free height above it, metres; infinite under the open air.
    pub headroom: f64,
    /// Whether it reaches down to the floor in one piece.
    pub solid: bool,
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

    /// Distance of a point from it, metres; negative inside.
    pub fn distance(&self, from_center: &Vector2<f64>) -> f64 {
        match *self {
            Outline::Disc { radius } => from_center.norm() - radius,
            Outline::Rectangle { half_extents: [x, y] } => {
                let beside = from_center.abs() - Vector2::new(x, y);
                beside.map(|gap| gap.max(0.0)).norm() + beside.max().min(0.0)
            }
        }
    }

    /// One that reaches farther by this much on all sides, metres; corners stay sharp.
    pub fn grown(self, margin: f64) -> Self {
        match self {
            Outline::Disc { radius } => Outline::Disc { radius: radius + margin },
            Outline::Rectangle { half_extents } => {
                Outline::Rectangle { half_extents: half_extents.map(|half| half + margin) }
            }
        }
    }

    /// Area, square metres.
    pub fn area(&self) -> f64 {
        match *self {
            Outline::Disc { radius } => std::f64::consts::PI * radius * radius,
            Outline::Rectangle { half_extents: [x, y] } => 4.0 * x * y,
        }
    }
}

impl Stand {
    /// One that stands on the floor, in the open.
    pub fn solid(center: Vector2<f64>, height: f64, outline: Outline) -> Self {
        Self { center, height, outline, headroom: f64::INFINITY, solid: true }
    }

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
