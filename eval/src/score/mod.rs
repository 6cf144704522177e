//! Scores: estimate x truth -> a number, or `None` where the number is undefined. Never NaN.

pub mod adjusted_information;
pub mod align;
pub mod alignment;
pub mod association;
pub mod association_entry;
pub mod ate;
pub mod azimuth;
pub mod azimuth_information;
pub mod bound;
pub mod calibration;
pub mod clustering;
pub mod consistency;
pub mod decoder;
pub mod density;
pub mod embedded_set;
pub mod embedded_views;
pub mod embedding;
pub mod entry;
pub mod extents;
pub mod grounding;
pub mod heading;
pub mod identity;
pub mod instance_posterior;
pub mod known_views;
pub mod landmark;
pub mod likelihood;
pub mod object;
pub mod object_map;
pub mod object_map_file;
pub mod online;
pub mod pairs;
pub mod pca;
pub mod pose_error;
pub mod psnr;
pub mod relocation;
pub mod retrieval;
pub mod rpe;
pub mod semantics;
pub mod silhouette;
pub mod trajectory_scores;
pub mod unseen;
pub mod unseen_table;
pub mod viewpoint;
pub mod viewpoint_table;
pub mod ward;

use nalgebra::UnitQuaternion;

/// `sqrt(mean of squares)`, or `None` for no values.
fn root_mean_square(squares: impl ExactSizeIterator<Item = f64>) -> Option<f64> {
    let n = squares.len();
    (n > 0).then(|| (squares.sum::<f64>() / n as f64).sqrt())
}

/// The angle between two rotations, radians in `[0, pi]`; exactly 0 for equal ones.
///
/// From the chord of the quaternions, `|a - b| = 2 sin(angle / 4)`, which loses no digits at small angles.
fn angle_between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    let chord = (a.coords - b.coords).norm().min((a.coords + b.coords).norm());
    4.0 * libm::asin((chord / 2.0).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use std::f64::consts::PI;

    #[test]
    fn angle_is_that_of_the_rotation_between_and_ignores_the_sign_of_a_quaternion() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.0, 0.2));
        for angle in [0.0, 1e-9, 1e-4, 1.0, 3.0, PI] {
            let b = a * UnitQuaternion::from_scaled_axis(Vector3::new(0.6, 0.8, 0.0) * angle);
            assert_relative_eq!(angle_between(&a, &b), angle, epsilon = 1e-7 * angle + 1e-16);
            let flipped = UnitQuaternion::new_unchecked(-b.into_inner());
            assert_relative_eq!(angle_between(&a, &flipped), angle, epsilon = 1e-7 * angle + 1e-16);
        }
        assert_eq!(angle_between(&a, &a), 0.0);
    }
}
