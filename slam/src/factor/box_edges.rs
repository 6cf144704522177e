//! The geometric measurement P(z^g | x, o) of Eq. 6 with an ellipsoid for the object: its outline against the edges of a box.

use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector, Matrix3, RowVector3, Vector3};
use vantage_dataset::Pose;
use vantage_dataset::se3::hat;

/// The bounds of an ellipsoid's outline less those of the box, each over sigma: left, top, right, bottom, image coordinates over the
/// focal length.
///
/// A plane through the camera with normal `n` touches an ellipsoid with centre `p` and `M = R diag(a^2) R^T` where
/// `(n . p)^2 = n^T M n`; with `n = (1, 0, -t)` that is a quadratic equation in the bounds `t` along x, likewise along y (the dual
/// quadric of Rubino et al. 2018). The ellipsoid has the axes of the object's pose. Where the object is a point, its heading is not known:
/// the ellipsoid is one of revolution about the world's vertical, and its horizontal semi-axis the geometric mean of the first two.
///
/// Undefined where the ellipsoid is not wholly in front of the camera.
#[derive(Clone, Debug)]
pub struct BoxEdgesFactor {
    keys: [Key; 3],
    robot_from_camera: Pose,
    edges: [f64; 4],
    sigma: f64,
    kernel: Kernel,
}

/// A robot, an ellipsoid before its camera, and its outline.
struct Outline {
    /// Squared semi-axes.
    squares: Vector3<f64>,
    p_in_robot: Vector3<f64>,
    p_in_camera: Vector3<f64>,
    robot_from_object: Matrix3<f64>,
    camera_from_robot: Matrix3<f64>,
    bounds: [f64; 4],
}

impl BoxEdgesFactor {
    /// Of `object` (a pose or a point) with the logarithms of its semi-axes in metres, `extents`, from `robot`; `edges` are left, top,
    /// right and bottom as rays `(x / z, y / z)` of the camera.
    pub fn new(
        [robot, object, extents]: [Key; 3],
        robot_from_camera: Pose,
        edges: [f64; 4],
        sigma: f64,
        kernel: Kernel,
    ) -> Self {
        Self { keys: [robot, object, extents], robot_from_camera, edges, sigma, kernel }
    }

    fn outline(&self, values: &Values) -> Option<Outline> {
        let world_from_robot = values.pose(self.keys[0])?;
        let object = values.get(self.keys[1])?;
        let logs = values.vector(self.keys[2]).filter(|logs| logs.len() == 3)?;
        let matrix = |pose: &Pose| pose.rotation.to_rotation_matrix().into_inner();
        let p_in_robot = world_from_robot.inverse_transform_point(&object.position()?.into());
        let robot_from_world = matrix(world_from_robot).transpose();
        let across = (logs[0] + logs[1]) / 2.0;
        let (robot_from_object, logs) = match object {
            Value::Pose(pose) => (robot_from_world * matrix(pose), [logs[0], logs[1], logs[2]]),
            _ => (robot_from_world, [across, across, logs[2]]),
        };
        let mut outline = Outline {
            squares: Vector3::from(logs.map(|log| libm::exp(2.0 * log))),
            p_in_robot: p_in_robot.coords,
            p_in_camera: self.robot_from_camera.inverse_transform_point(&p_in_robot).coords,
            robot_from_object,
            camera_from_robot: matrix(&self.robot_from_camera).transpose(),
            bounds: [0.0; 4],
        };
        let axes = outline.camera_from_robot * robot_from_object;
        let m = axes * Matrix3::from_diagonal(&outline.squares) * axes.transpose();
        let p = outline.p_in_camera;
        for axis in 0..2 {
            let a = p.z * p.z - m[(2, 2)];
            let b = p[axis] * p.z - m[(axis, 2)];
            let c = p[axis] * p[axis] - m[(axis, axis)];
            let root = (b * b - a * c).sqrt();
            if !(p.z > 0.0 && a > 0.0 && root > 0.0) {
                return None;
            }
            outline.bounds[axis] = (b - root) / a;
            outline.bounds[axis + 2] = (b + root) / a;
        }
        Some(outline)
    }

    fn whitened(&self, outline: &Outline) -> DVector<f64> {
        DVector::from_fn(4, |i, _| (outline.bounds[i] - self.edges[i]) / self.sigma)
    }
}

impl Factor for BoxEdgesFactor {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        finite(self.whitened(&self.outline(values)?))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let outline = self.outline(values)?;
        let object = values.get(self.keys[1])?;
        let mut d_robot = DMatrix::zeros(4, 6);
        let mut d_object = DMatrix::zeros(4, object.dim());
        let mut d_extents = DMatrix::zeros(4, 3);
        let robot_from_object = outline.robot_from_object;
        for (i, &t) in outline.bounds.iter().enumerate() {
            let mut normal = Vector3::new(0.0, 0.0, -t);
            normal[i % 2] = 1.0;
            let n_in_robot = outline.camera_from_robot.transpose() * normal;
            let n_in_object = robot_from_object.transpose() * n_in_robot;
            let weighted = outline.squares.component_mul(&n_in_object);
            let reach = normal.dot(&outline.p_in_camera);
            // Of F(t) = (n . p)^2 - n^T M n; dt = -dF / F'.
            let m_n = outline.camera_from_robot * robot_from_object * weighted;
            let slope = 2.0 * (m_n.z - reach * outline.p_in_camera.z);
            let scale = -2.0 / (slope * self.sigma);
            let d_point: RowVector3<f64> = n_in_robot.transpose() * (reach * scale);
            let d_normal: RowVector3<f64> = weighted.transpose() * -scale;
            let turned = d_point * hat(&outline.p_in_robot)
                - d_normal * robot_from_object.transpose() * hat(&n_in_robot);
            d_robot.view_mut((i, 0), (1, 3)).copy_from(&turned);
            d_robot.view_mut((i, 3), (1, 3)).copy_from(&-d_point);
            let d_center = d_point * robot_from_object;
            if object.dim() == 6 {
                d_object.view_mut((i, 0), (1, 3)).copy_from(&(d_normal * hat(&n_in_object)));
            }
            d_object.view_mut((i, object.dim() - 3), (1, 3)).copy_from(&d_center);
            let mut d_logs = weighted.component_mul(&n_in_object).transpose() * -scale;
            if object.dim() == 3 {
                let across = (d_logs[0] + d_logs[1]) / 2.0;
                (d_logs[0], d_logs[1]) = (across, across);
            }
            d_extents.view_mut((i, 0), (1, 3)).copy_from(&d_logs);
        }
        LinearFactor { residual: self.whitened(&outline), jacobians: vec![d_robot, d_object, d_extents] }
            .finite()
    }

    fn kernel(&self) -> Kernel {
        self.kernel
    }
}
