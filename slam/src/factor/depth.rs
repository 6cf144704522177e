//! The geometric measurement P(z^g | x, o) of Eq. 6 where a detection tells how far off the object's centre is.

use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector, Point3, RowVector3};
use vantage_dataset::se3::hat;
use vantage_dataset::{CenterDepth, Pose};

/// `([T_camera^-1 x^-1 o]_z - z) / sigma`, with `o` the object's centre and `z` the measured depth along the optical axis.
#[derive(Clone, Debug)]
pub struct DepthFactor {
    keys: [Key; 2],
    robot_from_camera: Pose,
    depth: CenterDepth,
    kernel: Kernel,
}

impl DepthFactor {
    /// A depth of `object` (a pose or a point) from `robot`.
    pub fn new(robot: Key, object: Key, robot_from_camera: Pose, depth: CenterDepth, kernel: Kernel) -> Self {
        Self { keys: [robot, object], robot_from_camera, depth, kernel }
    }

    fn p_in_robot(&self, values: &Values) -> Option<Point3<f64>> {
        let position = values.get(self.keys[1])?.position()?;
        Some(values.pose(self.keys[0])?.inverse_transform_point(&position.into()))
    }

    fn whitened(&self, p_in_robot: &Point3<f64>) -> DVector<f64> {
        let p_in_camera = self.robot_from_camera.inverse_transform_point(p_in_robot);
        DVector::from_element(1, (p_in_camera.z - self.depth.meters) / self.depth.sigma)
    }
}

impl Factor for DepthFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        finite(self.whitened(&self.p_in_robot(values)?))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let world_from_robot = values.pose(self.keys[0])?;
        let p_in_robot = self.p_in_robot(values)?;
        let matrix = |pose: &Pose| pose.rotation.to_rotation_matrix().into_inner();
        // The optical axis in the robot's frame.
        let axis: RowVector3<f64> = matrix(&self.robot_from_camera).column(2).transpose() / self.depth.sigma;
        let mut d_robot = DMatrix::zeros(1, 6);
        d_robot.view_mut((0, 0), (1, 3)).copy_from(&(axis * hat(&p_in_robot.coords)));
        d_robot.view_mut((0, 3), (1, 3)).copy_from(&-axis);
        let d_position = axis * matrix(world_from_robot).transpose();
        let d_object = match values.get(self.keys[1])? {
            Value::Pose(pose) => {
                let mut d_object = DMatrix::zeros(1, 6);
                d_object.view_mut((0, 3), (1, 3)).copy_from(&(d_position * matrix(pose)));
                d_object
            }
            Value::Point(_) => DMatrix::from_row_slice(1, 3, d_position.as_slice()),
            Value::Vector(_) => return None,
        };
        LinearFactor { residual: self.whitened(&p_in_robot), jacobians: vec![d_robot, d_object] }.finite()
    }

    fn kernel(&self) -> Kernel {
        self.kernel
    }
}
