//! A robot that goes from view to view of a session, and knows where it is by odometry alone.

use crate::scene::OdometrySpec;
use crate::sensor::odometry;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use vantage_dataset::{Pose, Seed, Sighting, Viewpoint};

/// Replaces the true `object_from_camera` of a session's sightings by what odometry makes of it.
///
/// The robot visits the views by azimuth. It stands under the camera and heads where that looks; height, pitch and roll of
/// the camera on it are known, as of a robot that measures gravity.
pub fn dead_reckon(spec: &OdometrySpec, session: &mut [(&Viewpoint, &mut Sighting)], seed: Seed) {
    session.sort_by(|(a, _), (b, _)| a.azimuth().total_cmp(&b.azimuth()));
    let track: Vec<Pose> =
        session.iter().map(|(_, sighting)| upright(&sighting.session_from_camera)).collect();
    let motions = odometry::measure(spec, &track, None, seed);
    let mut session_from_robot = Pose::identity();
    for (step, (_, sighting)) in session.iter_mut().enumerate() {
        if let Some(motion) = step.checked_sub(1).map(|last| &motions[last]) {
            session_from_robot *= motion.robot_from_robot;
        }
        sighting.step = step;
        sighting.session_from_camera =
            session_from_robot * track[step].inv_mul(&sighting.session_from_camera);
    }
}

/// The upright frame at a camera that heads where the camera looks, `object_from_robot`.
fn upright(object_from_camera: &Pose) -> Pose {
    let forward = object_from_camera.rotation * Vector3::z();
    let heading = libm::atan2(forward.y, forward.x);
    Pose::from_parts(
        Translation3::from(object_from_camera.translation.vector),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::mount::looking;
    use vantage_dataset::sighting::estimated_viewpoints;

    const SIZE: f64 = 0.3;

    /// Views at the given azimuths, each with the box that its viewpoint and [`SIZE`] call for.
    fn session(azimuths: &[f64]) -> Vec<(Viewpoint, Sighting)> {
        let made = |azimuth: &f64| {
            let direction = looking(*azimuth, 0.4) * Vector3::z();
            let rotation = looking(azimuth + std::f64::consts::PI, -0.4);
            let object_from_camera = Pose::from_parts(Translation3::from(direction * 1.5), rotation);
            let angular_size = SIZE / vantage_dataset::sighting::DIAMETER_PER_BOX / 1.5;
            let sighting =
                Sighting { step: 0, session_from_camera: object_from_camera, ray: [0.0; 2], angular_size };
            (Viewpoint::new(&object_from_camera, SIZE).unwrap(), sighting)
        };
        azimuths.iter().map(made).collect()
    }

    fn spec(noise: f64) -> OdometrySpec {
        OdometrySpec {
            translation_per_metre: noise,
            rotation_deg_per_metre: 20.0 * noise,
            rotation_per_radian: noise,
            out_of_plane: 0.0,
            bias_translation_per_metre: 0.0,
            bias_rotation_deg_per_metre: 0.0,
            slip: None,
        }
    }

    /// Errors of the estimated changes of azimuth since the first stop, by stop.
    fn errors(noise: f64, seed: u64) -> Vec<f64> {
        let mut made = session(&[1.0, -2.0, 0.2, 2.4]);
        let mut open: Vec<_> = made.iter_mut().map(|(viewpoint, sighting)| (&*viewpoint, sighting)).collect();
        dead_reckon(&spec(noise), &mut open, Seed(seed));
        made.sort_by_key(|(_, sighting)| sighting.step);
        assert_eq!(made.iter().map(|(_, sighting)| sighting.step).collect::<Vec<_>>(), [0, 1, 2, 3]);
        let sightings: Vec<_> = made.iter().map(|(_, sighting)| sighting).collect();
        let found: Vec<_> = estimated_viewpoints(&sightings).into_iter().flatten().collect();
        assert_eq!(found.len(), made.len());
        let offset = |stop: usize| made[stop].0.turned(-found[stop].azimuth()).azimuth();
        (0..made.len())
            .map(|stop| made[stop].0.turned(-found[stop].azimuth() - offset(0)).azimuth().abs())
            .collect()
    }

    #[test]
    fn odometry_without_error_gives_the_changes_of_azimuth_and_errors_grow_along_the_way() {
        assert!(errors(0.0, 1).iter().all(|error| *error < 2e-3), "{:?}", errors(0.0, 1));
        let mean = |stop: usize| (0..200).map(|seed| errors(0.05, seed)[stop]).sum::<f64>() / 200.0;
        let (first, last) = (mean(1), mean(3));
        assert!(first > 0.01 && last > 1.2 * first && last < 0.5, "{first} {last}");
    }

    #[test]
    fn the_first_stop_is_the_origin_and_height_and_pitch_are_kept() {
        let mut made = session(&[0.5, 0.9]);
        let truth = made[0].1.session_from_camera;
        let mut open: Vec<_> = made.iter_mut().map(|(viewpoint, sighting)| (&*viewpoint, sighting)).collect();
        dead_reckon(&spec(0.05), &mut open, Seed(2));
        let camera = made[0].1.session_from_camera;
        assert!(camera.translation.vector.norm() < 1e-12);
        let pitch = |pose: &Pose| (pose.rotation * Vector3::z()).z;
        assert!((pitch(&camera) - pitch(&truth)).abs() < 1e-12);
    }
}
