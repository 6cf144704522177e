//! A bearing whose box lies off its object by a smooth function of the view: Eq. 6 with the offset as a variable.

use super::{BearingFactor, Factor, LinearFactor, finite};
use crate::bearing_offset::{BearingOffset, Harmonics};
use crate::noise::Kernel;
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector, Matrix2x3, Matrix3, RowVector3, Vector2};
use vantage_dataset::Pose;
use vantage_dataset::se3::hat;

/// Least horizontal distance of camera and object, metres, that makes an azimuth.
const LEAST_DISTANCE: f64 = 1e-9;

/// A bearing's residual plus `S phi(a)^T c`, horizontal and vertical, `S = diag(sigma_h, sigma_v) angular_size / sigma`.
///
/// `a` is the azimuth, in the world, of the direction from object to camera, and `c` is `[c_h; c_v]`.
#[derive(Clone, Debug)]
pub struct OffsetBearingFactor {
    keys: [Key; 3],
    bearing: BearingFactor,
    robot_from_camera: Pose,
    harmonics: Harmonics,
    /// Image x and y.
    scale: Vector2<f64>,
}

impl OffsetBearingFactor {
    /// `bearing`, of a box of `angular_size` and white noise of `sigma`, with the offset of `track`.
    pub fn new(
        bearing: BearingFactor,
        track: usize,
        offset: &BearingOffset,
        angular_size: f64,
        sigma: f64,
    ) -> Self {
        let [robot, object] = bearing.keys;
        Self {
            keys: [robot, object, Key::Offset(track)],
            robot_from_camera: bearing.robot_from_camera,
            bearing,
            harmonics: offset.harmonics(),
            scale: Vector2::new(offset.horizontal, offset.vertical) * (angular_size / sigma),
        }
    }

    /// Numbers of an offset's variable.
    pub fn dim(offset: &BearingOffset) -> usize {
        2 * offset.harmonics().count()
    }

    fn view(&self, values: &Values) -> Option<View> {
        let world_from_robot = values.pose(self.keys[0])?;
        let object = values.get(self.keys[1])?.position()?;
        let camera_in_robot = self.robot_from_camera.translation.vector;
        let from_object = world_from_robot.transform_point(&camera_in_robot.into()).coords - object;
        let distance = libm::hypot(from_object.x, from_object.y);
        if distance <= LEAST_DISTANCE {
            return None;
        }
        let (phi, d_phi) = self.harmonics.at([from_object.x / distance, from_object.y / distance]);
        let coefficients = values.vector(self.keys[2]).filter(|c| c.len() == 2 * phi.len())?;
        let along = |features: &DVector<f64>| {
            let count = features.len();
            let [x, y] = [0, count].map(|first| features.dot(&coefficients.rows(first, count)));
            self.scale.component_mul(&Vector2::new(x, y))
        };
        let d_azimuth = RowVector3::new(-from_object.y, from_object.x, 0.0) / (distance * distance);
        Some(View { offset: along(&phi), d_offset: along(&d_phi) * d_azimuth, phi })
    }
}

/// The offset under one view.
struct View {
    /// Whitened.
    offset: Vector2<f64>,
    /// Its derivative to the camera's position in the world.
    d_offset: Matrix2x3<f64>,
    phi: DVector<f64>,
}

impl Factor for OffsetBearingFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let offset = self.view(values)?.offset;
        finite(self.bearing.residual(values)? + DVector::from_column_slice(offset.as_slice()))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let View { offset, d_offset, phi } = self.view(values)?;
        let LinearFactor { mut residual, mut jacobians } = self.bearing.linearize(values)?;
        residual += DVector::from_column_slice(offset.as_slice());

        let world_from_robot = values.pose(self.keys[0])?.rotation.to_rotation_matrix().into_inner();
        let d_translation = d_offset * world_from_robot;
        let camera_in_robot = self.robot_from_camera.translation.vector;
        let mut d_robot = jacobians[0].view_mut((0, 0), (2, 6));
        d_robot.columns_mut(0, 3).zip_apply(&(d_translation * hat(&camera_in_robot)), |to, d| *to -= d);
        d_robot.columns_mut(3, 3).zip_apply(&d_translation, |to, d| *to += d);

        let (world_from_object, first) = match values.get(self.keys[1])? {
            Value::Pose(pose) => (pose.rotation.to_rotation_matrix().into_inner(), 3),
            _ => (Matrix3::identity(), 0),
        };
        let d_position = d_offset * world_from_object;
        jacobians[1].columns_mut(first, 3).zip_apply(&d_position, |to, d| *to -= d);

        let count = phi.len();
        let mut d_coefficients = DMatrix::zeros(2, 2 * count);
        d_coefficients.view_mut((0, 0), (1, count)).copy_from(&(phi.transpose() * self.scale.x));
        d_coefficients.view_mut((1, count), (1, count)).copy_from(&(phi.transpose() * self.scale.y));
        jacobians.push(d_coefficients);
        LinearFactor { residual, jacobians }.finite()
    }

    fn kernel(&self) -> Kernel {
        self.bearing.kernel()
    }
}
