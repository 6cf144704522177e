//! Lines of sight, and the point nearest to several: `sum w A p = sum w A o`, where `A = I - d d^T`.

use crate::se3::Pose;
use nalgebra::{Matrix3, Point3, Vector3};

/// A line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the camera is: `o`.
    pub origin: Point3<f64>,
    /// Unit vector: `d`.
    pub direction: Vector3<f64>,
}

impl Ray {
    /// The ray of a camera along `ray_in_camera`, of any length.
    pub fn new(world_from_camera: &Pose, ray_in_camera: &Vector3<f64>) -> Self {
        Self {
            origin: world_from_camera.translation.vector.into(),
            direction: (world_from_camera.rotation * ray_in_camera).normalize(),
        }
    }

    /// `A`, which projects on the plane across the ray.
    pub fn across(&self) -> Matrix3<f64> {
        Matrix3::identity() - self.direction * self.direction.transpose()
    }
}

/// The normal equations of the point nearest to some rays, in the least-squares sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// `sum w A`. Its eigenvalues tell how well the rays tell the point.
    pub normal: Matrix3<f64>,
    /// `sum w A o`.
    pub right: Vector3<f64>,
}

impl Meeting {
    /// Of rays with their weights.
    pub fn of(weighted: impl IntoIterator<Item = (Ray, f64)>) -> Self {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (ray, weight) in weighted {
            let across = ray.across() * weight;
            normal += across;
            right += across * ray.origin.coords;
        }
        Self { normal, right }
    }

    /// The point `p`; none where the rays are parallel, or nothing is known of them.
    pub fn point(&self) -> Option<Point3<f64>> {
        Some(Point3::from(self.normal.cholesky()?.solve(&self.right)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn rays_meet_where_they_cross_and_nearer_to_those_of_more_weight() {
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        let along = |origin, direction| Ray { origin, direction };
        let (low, high) = (along(at(-1.0, 0.0, 0.0), Vector3::x()), along(at(0.0, -1.0, 1.0), Vector3::y()));
        let crossing = along(at(0.0, -1.0, 0.0), Vector3::y());
        let crossed = Meeting::of([(low, 1.0), (crossing, 1.0)]).point().unwrap();
        assert_relative_eq!(crossed, at(0.0, 0.0, 0.0), epsilon = 1e-15);
        let met = Meeting::of([(low, 1.0), (high, 3.0)]).point().unwrap();
        assert_relative_eq!(met, at(0.0, 0.0, 0.75), epsilon = 1e-15);
    }

    #[test]
    fn parallel_rays_meet_nowhere() {
        let ray = |x: f64| Ray { origin: Point3::new(x, 0.0, 0.0), direction: Vector3::y() };
        assert_eq!(Meeting::of([(ray(0.0), 1.0), (ray(1.0), 1.0)]).point(), None);
        assert_eq!(Meeting::of([]).point(), None);
    }

    #[test]
    fn a_camera_s_ray_starts_at_it() {
        let pose = Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::z() * std::f64::consts::FRAC_PI_2);
        let ray = Ray::new(&pose, &(Vector3::x() * 2.0));
        assert_relative_eq!(ray.origin, Point3::new(1.0, 2.0, 3.0));
        assert_relative_eq!(ray.direction, Vector3::y(), epsilon = 1e-15);
    }
}
