//! `Delta X` of Eq. 15-20 as numbers that a network is told: from the object's point of view, or the camera's.

use crate::role::{CAMERA_MOTION, OBJECT_CENTRED_CHANGE};
use vantage_dataset::viewpoint::HARMONICS;
use vantage_dataset::{Pose, Viewpoint};

/// The numbers of [`Convention::ObjectCentredChange`](crate::Convention::ObjectCentredChange), from the viewpoints of
/// two crops of one object.
///
/// `[cos md, sin md for m = 1..=5]` of the change `d` of azimuth, second less first, then
/// `[sin elevation, cos roll, sin roll, log(distance / size)]` of the first view, then of the second. They do not
/// depend on where the object's own azimuth is 0.
pub fn object_centred_change(first: &Viewpoint, second: &Viewpoint) -> [f64; OBJECT_CENTRED_CHANGE] {
    let delta = second.azimuth() - first.azimuth();
    let mut numbers = [0.0; OBJECT_CENTRED_CHANGE];
    for m in 1..=HARMONICS {
        (numbers[2 * m - 1], numbers[2 * m - 2]) = libm::sincos(m as f64 * delta);
    }
    let upright = |view: &Viewpoint| {
        let [.., elevation, cos_roll, sin_roll, distance] = view.conditioning();
        [elevation, cos_roll, sin_roll, distance]
    };
    let (_, tail) = numbers.split_at_mut(2 * HARMONICS);
    tail[..4].copy_from_slice(&upright(first));
    tail[4..].copy_from_slice(&upright(second));
    numbers
}

/// The numbers of [`Convention::CameraMotion`](crate::Convention::CameraMotion): the first and the second column of
/// the rotation, then the translation in metres, of `first_camera_from_second_camera`.
pub fn camera_motion(first_camera_from_second_camera: &Pose) -> [f64; CAMERA_MOTION] {
    let rotation = first_camera_from_second_camera.rotation.to_rotation_matrix();
    let translation = first_camera_from_second_camera.translation.vector;
    let mut numbers = [0.0; CAMERA_MOTION];
    numbers[..6].copy_from_slice(&rotation.matrix().as_slice()[..6]);
    numbers[6..].copy_from_slice(translation.as_slice());
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{Unit, Vector3};

    fn view(azimuth: f64) -> Viewpoint {
        let direction = Vector3::new(azimuth.cos(), azimuth.sin(), 0.5);
        let direction = Unit::new_normalize(direction).into_inner();
        Viewpoint { direction, roll: 0.1 * azimuth, log_distance: 1.0 + azimuth }
    }

    #[test]
    fn an_object_centred_change_is_the_same_for_a_turned_object() {
        let (first, second) = (view(0.3), view(1.1));
        let change = object_centred_change(&first, &second);
        assert_relative_eq!(change[0], 0.8f64.cos(), epsilon = 1e-12);
        assert_relative_eq!(change[3], 1.6f64.sin(), epsilon = 1e-12);
        assert_relative_eq!(change[12], 0.03f64.sin(), epsilon = 1e-12);
        assert_relative_eq!(change[17], 2.1, epsilon = 1e-12);
        let turned = object_centred_change(&first.turned(2.5), &second.turned(2.5));
        for (number, turned) in change.iter().zip(turned) {
            assert_relative_eq!(*number, turned, epsilon = 1e-12);
        }
    }

    #[test]
    fn a_camera_motion_is_columns_then_translation() {
        let quarter = Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::z() * std::f64::consts::FRAC_PI_2);
        let expected = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 2.0, 3.0];
        for (number, expected) in camera_motion(&quarter).iter().zip(expected) {
            assert_relative_eq!(*number, expected, epsilon = 1e-12);
        }
    }
}
