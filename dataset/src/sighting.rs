//! What a robot without ground truth knows of a view: odometry and a box (Eq. 16-19).

use crate::median::upper_median;
use crate::ray::{Meeting, Ray};
use crate::se3::Pose;
use crate::viewpoint::Viewpoint;
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

/// An object's diameter over the longer side of its box at the object's distance, fitted on validation instances.
pub const DIAMETER_PER_BOX: f64 = 1.1;

/// Least ratio of the extreme eigenvalues of a triangulation's normal matrix: rays that are all but parallel meet nowhere.
const LEAST_CONDITION: f64 = 1e-4;

/// A view of an object as a robot met it on its way through a session.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting {
    /// Number of the view along the way.
    pub step: usize,
    /// The camera by odometry alone. The session's frame is z up; its origin and heading are those of the first view.
    pub session_from_camera: Pose,
    /// The box's centre as a ray `(x / z, y / z)`, camera frame.
    pub ray: [f64; 2],
    /// Longer side of the box over the focal length.
    pub angular_size: f64,
}

impl Sighting {
    /// The line of sight to the box's centre, session frame.
    fn line(&self) -> Ray {
        let direction =
            self.session_from_camera.rotation * Vector3::new(self.ray[0], self.ray[1], 1.0).normalize();
        Ray { origin: self.session_from_camera.translation.vector.into(), direction }
    }
}

/// Where the object of some sightings is, session frame: the point nearest to their rays, in the least-squares sense.
///
/// `None` with fewer than two sightings, or where the rays are all but parallel or meet behind a camera.
pub fn triangulated(sightings: &[&Sighting]) -> Option<Point3<f64>> {
    let meeting = Meeting::of(sightings.iter().map(|sighting| (sighting.line(), 1.0)));
    let eigenvalues = meeting.normal.symmetric_eigenvalues();
    let well_posed = eigenvalues.min() > LEAST_CONDITION * eigenvalues.max();
    let center = meeting.point().filter(|_| well_posed)?;
    let in_front =
        |sighting: &&Sighting| sighting.session_from_camera.inverse_transform_point(&center).z > 0.0;
    sightings.iter().all(in_front).then_some(center)
}

/// The viewpoints of sightings of one object in one session, by odometry and boxes alone.
///
/// The object's frame is the session's, moved to the triangulated centre: z up, its heading that of the session, so that
/// azimuths mean something only relative to each other. Its size is the upper median of box side times depth. `None` for all
/// where the object cannot be triangulated, for one where [`Viewpoint::new`] has none.
pub fn estimated_viewpoints(sightings: &[&Sighting]) -> Vec<Option<Viewpoint>> {
    let Some(center) = triangulated(sightings) else { return vec![None; sightings.len()] };
    let session_from_object = Pose::from_parts(Translation3::from(center), UnitQuaternion::identity());
    let side = |sighting: &&Sighting| {
        sighting.angular_size * sighting.session_from_camera.inverse_transform_point(&center).z
    };
    let Some(side) = upper_median(sightings.iter().map(side).collect()) else { return Vec::new() };
    let size = DIAMETER_PER_BOX * side;
    let seen = |sighting: &&Sighting| {
        Viewpoint::new(&session_from_object.inv_mul(&sighting.session_from_camera), size)
    };
    sightings.iter().map(seen).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Cameras on a circle of radius 2 around an object of diameter 0.33 at `center`, looking at its middle.
    fn circle(center: Point3<f64>, azimuths: &[f64]) -> Vec<Sighting> {
        let sighting = |(step, azimuth): (usize, &f64)| {
            let eye = center + Vector3::new(2.0 * azimuth.cos(), 2.0 * azimuth.sin(), 0.6);
            Sighting {
                step,
                session_from_camera: Pose::face_towards(&eye, &center, &-Vector3::z()),
                ray: [0.0; 2],
                angular_size: 0.3 / (center - eye).norm(),
            }
        };
        azimuths.iter().enumerate().map(sighting).collect()
    }

    #[test]
    fn rays_without_error_meet_at_the_object() {
        let center = Point3::new(0.7, -0.4, 0.9);
        let azimuths = [0.1, 0.6, 2.0];
        let sightings = circle(center, &azimuths);
        let sightings: Vec<&Sighting> = sightings.iter().collect();
        assert_relative_eq!(triangulated(&sightings).unwrap(), center, epsilon = 1e-9);
        for (viewpoint, azimuth) in estimated_viewpoints(&sightings).into_iter().zip(azimuths) {
            let viewpoint = viewpoint.unwrap();
            assert_relative_eq!(viewpoint.azimuth(), azimuth, epsilon = 1e-9);
            assert_relative_eq!(viewpoint.roll, 0.0, epsilon = 1e-9);
            assert_relative_eq!(viewpoint.log_distance, (4.36f64.sqrt() / 0.33).ln(), epsilon = 1e-9);
        }
    }

    #[test]
    fn rays_that_meet_nowhere_or_behind_give_nothing() {
        let mut sightings = circle(Point3::origin(), &[0.0, 0.0]);
        sightings[1].session_from_camera.translation.vector.x += 1.0;
        let both: Vec<&Sighting> = sightings.iter().collect();
        assert_eq!(triangulated(&both[..1]), None);
        assert_eq!(estimated_viewpoints(&both[..1]), vec![None]);
        let mut behind = circle(Point3::origin(), &[0.0, 1.0]);
        for sighting in &mut behind {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
            sighting.session_from_camera.rotation *= turn;
        }
        assert_eq!(triangulated(&behind.iter().collect::<Vec<_>>()), None);
    }
}
