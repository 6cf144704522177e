//! The geometric measurement P(z^g | x, o) of Eq. 6: the centre of a box as a bearing to the object's centre.

use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Matrix3, Matrix3x2, Vector2, Vector3};
use vantage_dataset::Pose;
use vantage_dataset::se3::hat;

const SMALL_SINE: f64 = 1e-4;
/// A camera is never nearer to an object's centre, metres: there any bearing could be had.
const NEAREST: f64 = 0.01;

/// The angle from the measured ray to the object, as a vector of the ray's tangent plane, whitened.
///
/// The measurement noise is that of the image coordinates over the focal length; it is carried to the tangent
/// plane to first order. Unlike those coordinates, the angle stays defined for an object beside or behind the
/// camera, where a bad start value may put it.
#[derive(Clone, Debug)]
pub struct BearingFactor {
    pub(super) keys: [Key; 2],
    pub(super) robot_from_camera: Pose,
    ray: Vector3<f64>,
    tangent: Matrix2x3<f64>,
    sqrt_information: Matrix2<f64>,
    kernel: Kernel,
}

impl BearingFactor {
    /// A bearing of `object` (a pose or a point) from `robot` along `ray_in_camera` (`z = 1`), with `sigma`
    /// the standard deviation of the ray's x and y.
    pub fn new(
        robot: Key,
        object: Key,
        robot_from_camera: Pose,
        ray_in_camera: &Vector3<f64>,
        sigma: f64,
        kernel: Kernel,
    ) -> Self {
        let length = ray_in_camera.norm();
        let ray = ray_in_camera / length;
        let sideways = if ray.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
        let first = (sideways - ray * ray.dot(&sideways)).normalize();
        let second = ray.cross(&first);
        let tangent = Matrix2x3::from_rows(&[first.transpose(), second.transpose()]);
        let tangent_from_image: Matrix2<f64> = tangent * Matrix3x2::identity() / length;
        let sqrt_information =
            tangent_from_image.try_inverse().unwrap_or_else(|| Matrix2::identity() * length) / sigma;
        Self { keys: [robot, object], robot_from_camera, ray, tangent, sqrt_information, kernel }
    }

    fn object_position(&self, values: &Values) -> Option<Vector3<f64>> {
        values.get(self.keys[1])?.position()
    }

    fn p_in_robot(&self, values: &Values) -> Option<Vector3<f64>> {
        let world_from_robot = values.pose(self.keys[0])?;
        Some(world_from_robot.inverse_transform_point(&self.object_position(values)?.into()).coords)
    }

    fn direction(&self, p_in_robot: &Vector3<f64>) -> Option<Direction> {
        let p_in_camera = self.robot_from_camera.inverse_transform_point(&(*p_in_robot).into()).coords;
        let distance = p_in_camera.norm();
        let unit = p_in_camera / distance;
        let off = self.tangent * unit;
        let (sine, cosine) = (off.norm(), self.ray.dot(&unit));
        let antipodal = sine < SMALL_SINE && cosine < 0.0;
        (distance > NEAREST && !antipodal).then_some(Direction { distance, unit, off, sine, cosine })
    }
}

/// The direction to the object against the measured ray.
struct Direction {
    distance: f64,
    unit: Vector3<f64>,
    off: Vector2<f64>,
    sine: f64,
    cosine: f64,
}

impl Direction {
    /// `(k, f)`: angle over sine, and `dk = f off . d(off) - d(cosine)`.
    fn angle_over_sine(&self) -> (f64, f64) {
        let (n, c) = (self.sine, self.cosine);
        if n < SMALL_SINE {
            return (1.0 + n * n / 6.0, -2.0 / 3.0);
        }
        let angle = libm::atan2(n, c);
        (angle / n, (c * n - angle) / (n * n * n))
    }
}

impl Factor for BearingFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let direction = self.direction(&self.p_in_robot(values)?)?;
        let r = self.sqrt_information * direction.off * direction.angle_over_sine().0;
        finite(DVector::from_column_slice(r.as_slice()))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let world_from_robot = values.pose(self.keys[0])?;
        let p_in_robot = self.p_in_robot(values)?;
        let direction = self.direction(&p_in_robot)?;
        let (k, f) = direction.angle_over_sine();
        let unit = direction.unit;

        let d_unit = (Matrix3::identity() - unit * unit.transpose()) / direction.distance;
        let d_off = self.tangent * d_unit;
        let d_k = direction.off.transpose() * d_off * f - self.ray.transpose() * d_unit;
        let camera_from_robot = self.robot_from_camera.rotation.inverse().to_rotation_matrix().into_inner();
        let d_robot_point: Matrix2x3<f64> =
            self.sqrt_information * (d_off * k + direction.off * d_k) * camera_from_robot;

        let mut d_robot = DMatrix::zeros(2, 6);
        d_robot.view_mut((0, 0), (2, 3)).copy_from(&(d_robot_point * hat(&p_in_robot)));
        d_robot.view_mut((0, 3), (2, 3)).copy_from(&-d_robot_point);
        let robot_from_world = world_from_robot.rotation.inverse().to_rotation_matrix().into_inner();
        let d_position = d_robot_point * robot_from_world;
        let d_object = match values.get(self.keys[1])? {
            Value::Pose(pose) => {
                let mut d_object = DMatrix::zeros(2, 6);
                let rotation = pose.rotation.to_rotation_matrix().into_inner();
                d_object.view_mut((0, 3), (2, 3)).copy_from(&(d_position * rotation));
                d_object
            }
            Value::Point(_) => DMatrix::from_column_slice(2, 3, d_position.as_slice()),
            Value::Vector(_) => return None,
        };
        let r = self.sqrt_information * direction.off * k;
        LinearFactor {
            residual: DVector::from_column_slice(r.as_slice()),
            jacobians: vec![d_robot, d_object],
        }
        .finite()
    }

    fn kernel(&self) -> Kernel {
        self.kernel
    }
}
