//! What is solid, for the physics engine.

use crate::convert::{pose_to_physics, vector_to_physics};
use crate::plan::block::Block;
use crate::plan::stand::{Outline, Stand};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rapier3d::glamx::Pose3;
use rapier3d::prelude::SharedShape;
use std::f64::consts::FRAC_PI_2;
use vantage_dataset::Pose;

impl Block {
    /// It, less `slack` metres on all sides.
    pub fn shape(&self, slack: f64) -> (Pose3, SharedShape) {
        let half = vector_to_physics(&((self.max - self.min) / 2.0).add_scalar(-slack));
        let center = vector_to_physics(&((self.min + self.max) / 2.0));
        (Pose3::from_translation(center), SharedShape::cuboid(half.x, half.y, half.z))
    }
}

impl Stand {
    /// It and all below it.
    pub fn shape(&self) -> (Pose3, SharedShape) {
        let half_height = self.height / 2.0;
        let at = Translation3::from(self.center.push(half_height));
        match self.outline {
            Outline::Disc { radius } => {
                let pose = Pose::from_parts(at, standing_cylinder());
                (pose_to_physics(&pose), SharedShape::cylinder(half_height as f32, radius as f32))
            }
            Outline::Rectangle { half_extents: [x, y] } => {
                let pose = Pose::from_parts(at, UnitQuaternion::identity());
                (pose_to_physics(&pose), SharedShape::cuboid(x as f32, y as f32, half_height as f32))
            }
        }
    }
}

/// The engine's cylinders lie along y.
pub(super) fn standing_cylinder() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2)
}
