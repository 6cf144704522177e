//! From where a camera sees an object that is a pose, or a centre whose axes are the world's.

use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, Dyn, OMatrix, U6};
use vantage_dataset::{Pose, se3};

/// One sight of an object.
pub(super) struct View {
    /// `world_from_object^-1 world_from_robot robot_from_camera`.
    pub(super) object_from_camera: Pose,
    is_pose: bool,
}

impl View {
    /// That of the `[robot, object]` at some values; `None` where either has none that fits.
    pub(super) fn of([robot, object]: [Key; 2], values: &Values, robot_from_camera: &Pose) -> Option<Self> {
        let world_from_camera = values.pose(robot)? * robot_from_camera;
        let (object_from_camera, is_pose) = match values.get(object)? {
            Value::Pose(pose) => (pose.inv_mul(&world_from_camera), true),
            Value::Point(p) => (Pose::translation(p.x, p.y, p.z).inv_mul(&world_from_camera), false),
            Value::Vector(_) => return None,
        };
        Some(Self { object_from_camera, is_pose })
    }

    /// The derivatives by `[robot, object]` of what has the derivative `d_camera` by `object_from_camera`, all by right perturbations.
    pub(super) fn jacobians(
        &self,
        d_camera: &OMatrix<f64, Dyn, U6>,
        robot_from_camera: &Pose,
    ) -> [DMatrix<f64>; 2] {
        let dynamic = |m: OMatrix<f64, Dyn, U6>| DMatrix::from_column_slice(m.nrows(), 6, m.as_slice());
        let d_robot = dynamic(d_camera * se3::adjoint(&robot_from_camera.inverse()));
        let d_object = dynamic(-(d_camera * se3::adjoint(&self.object_from_camera.inverse())));
        // A centre moves as a pose whose axes stay the world's.
        let d_object = if self.is_pose { d_object } else { d_object.columns(3, 3).into_owned() };
        [d_robot, d_object]
    }
}
