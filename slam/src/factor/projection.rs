//! The geometric measurement P(z^g | x, l) of Eq. 6: the pixel of a point landmark.

use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector, Matrix2x3, Point3, Vector2};
use vantage_dataset::se3::hat;
use vantage_dataset::{Camera, LandmarkSighting, Pose};

/// `(pi(T_camera^-1 x^-1 l) - z) / sigma`, with `pi` the pinhole projection and `z` the measured pixel.
///
/// Undefined where the landmark is not in front of the camera.
#[derive(Clone, Debug)]
pub struct ProjectionFactor {
    keys: [Key; 2],
    robot_from_camera: Pose,
    camera: Camera,
    pixel: Vector2<f64>,
    sigma: f64,
    kernel: Kernel,
}

impl ProjectionFactor {
    /// The factor of a sighting: of the robot's pose at its step, and of its landmark (a point).
    pub fn new(sighting: &LandmarkSighting, camera: Camera, robot_from_camera: Pose, kernel: Kernel) -> Self {
        let LandmarkSighting { step, landmark, pixel, sigma } = *sighting;
        let keys = [Key::Robot(step), Key::Landmark(landmark)];
        Self { keys, robot_from_camera, camera, pixel, sigma, kernel }
    }

    fn p_in_robot(&self, values: &Values) -> Option<Point3<f64>> {
        let position = values.get(self.keys[1])?.position()?;
        Some(values.pose(self.keys[0])?.inverse_transform_point(&position.into()))
    }

    fn whitened(&self, p_in_camera: &Point3<f64>) -> Option<DVector<f64>> {
        let error = (self.camera.project(p_in_camera)? - self.pixel) / self.sigma;
        finite(DVector::from_column_slice(error.as_slice()))
    }
}

impl Factor for ProjectionFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.whitened(&self.robot_from_camera.inverse_transform_point(&self.p_in_robot(values)?))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let p_in_robot = self.p_in_robot(values)?;
        let p = self.robot_from_camera.inverse_transform_point(&p_in_robot);
        let residual = self.whitened(&p)?;
        let (fx, fy) = (self.camera.fx / p.z, self.camera.fy / p.z);
        let d_pixel = Matrix2x3::new(fx, 0.0, -fx * p.x / p.z, 0.0, fy, -fy * p.y / p.z) / self.sigma;
        let rotation = |pose: &Pose| pose.rotation.inverse().to_rotation_matrix().into_inner();
        let d_robot_point = d_pixel * rotation(&self.robot_from_camera);
        let d_landmark = d_robot_point * rotation(values.pose(self.keys[0])?);
        let mut d_robot = DMatrix::zeros(2, 6);
        d_robot.view_mut((0, 0), (2, 3)).copy_from(&(d_robot_point * hat(&p_in_robot.coords)));
        d_robot.view_mut((0, 3), (2, 3)).copy_from(&-d_robot_point);
        let d_landmark = DMatrix::from_column_slice(2, 3, d_landmark.as_slice());
        LinearFactor { residual, jacobians: vec![d_robot, d_landmark] }.finite()
    }

    fn kernel(&self) -> Kernel {
        self.kernel
    }
}
