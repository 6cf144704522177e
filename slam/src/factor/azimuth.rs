//! An azimuth read off a crop, as a sensor of the robot's and the object's pose.

use super::view::View;
use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::{DVector, Dyn, OMatrix, RowVector3, U6};
use std::f64::consts::PI;
use vantage_dataset::Pose;
use vantage_model::AzimuthReading;

/// `wrap(measured - azimuth) / sigma`, the azimuth that of the camera about the object's z axis, from
/// `object_from_camera = world_from_object^-1 world_from_robot robot_from_camera`.
#[derive(Clone, Debug)]
pub struct AzimuthFactor {
    keys: [Key; 2],
    reading: AzimuthReading,
    robot_from_camera: Pose,
    degrees_of_freedom: f64,
    information_scale: f64,
}

impl AzimuthFactor {
    /// Joins `[robot, object]`; the information scale multiplies the log-likelihood.
    pub fn new(
        keys: [Key; 2],
        reading: AzimuthReading,
        robot_from_camera: Pose,
        degrees_of_freedom: f64,
        information_scale: f64,
    ) -> Self {
        Self { keys, reading, robot_from_camera, degrees_of_freedom, information_scale }
    }

    fn view(&self, values: &Values) -> Option<View> {
        View::of(self.keys, values, &self.robot_from_camera)
    }

    fn whitened(&self, object_from_camera: &Pose) -> Option<DVector<f64>> {
        let p = object_from_camera.translation.vector;
        let error = wrapped(self.reading.azimuth - libm::atan2(p.y, p.x));
        finite(DVector::from_element(1, error / self.reading.sigma))
    }
}

impl Factor for AzimuthFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.whitened(&self.view(values)?.object_from_camera)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let view = self.view(values)?;
        let object_from_camera = view.object_from_camera;
        let p = object_from_camera.translation.vector;
        let rotation = object_from_camera.rotation.to_rotation_matrix().into_inner();
        let by_position = RowVector3::new(-p.y, p.x, 0.0) / (p.x * p.x + p.y * p.y);
        let mut d_camera = OMatrix::<f64, Dyn, U6>::zeros(1);
        d_camera.view_mut((0, 3), (1, 3)).copy_from(&(by_position * rotation / -self.reading.sigma));
        let jacobians = view.jacobians(&d_camera, &self.robot_from_camera).to_vec();
        LinearFactor { residual: self.whitened(&object_from_camera)?, jacobians }.finite()
    }

    fn kernel(&self) -> Kernel {
        Kernel::of_degrees_of_freedom(self.degrees_of_freedom)
    }

    fn information_scale(&self) -> f64 {
        self.information_scale
    }
}

/// An angle in `[-pi, pi)`.
fn wrapped(angle: f64) -> f64 {
    angle - 2.0 * PI * libm::floor((angle + PI) / (2.0 * PI))
}
