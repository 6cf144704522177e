//! Heading error: how far the robot's yaw is from what it thinks it is, radians.

use super::pairs::Pairs;
use super::root_mean_square;
use std::f64::consts::PI;
use vantage_dataset::Pose;

/// Root mean square of the yaw error once the first estimated pose is laid on the first true one.
///
/// Yaw is the angle, about the true world's z, of the robot's x axis laid on the ground; errors are wrapped to
/// `[-pi, pi)`. `None` for no pose.
pub fn heading_error(pairs: &Pairs) -> Option<f64> {
    let world_from_first = pairs.truth().first()?.rotation;
    let squares = pairs.from_first().map(|(truth, estimate)| {
        let yaw = |first_from_robot: &Pose| {
            let ahead = world_from_first * (first_from_robot.rotation * nalgebra::Vector3::x());
            libm::atan2(ahead.y, ahead.x)
        };
        let error = (yaw(&estimate) - yaw(&truth) + PI).rem_euclid(2.0 * PI) - PI;
        error * error
    });
    root_mean_square(squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use vantage_dataset::{Tangent, se3};

    fn yaw(angle: f64) -> Pose {
        Pose::rotation(Vector3::z() * angle)
    }

    #[test]
    fn a_known_error_is_measured_across_the_wrap() {
        let truth = [yaw(0.0), yaw(3.1)];
        let estimate = [yaw(1.0), yaw(1.0 - 3.1)];
        let error = heading_error(&Pairs::by_step(&truth, &estimate).unwrap()).unwrap();
        assert_relative_eq!(error, (2.0 * PI - 6.2) / 2f64.sqrt(), epsilon = 1e-12);
        assert_eq!(heading_error(&Pairs::by_step(&[], &[]).unwrap()), None);
    }

    #[test]
    fn tilt_of_the_first_pose_does_not_turn_roll_into_heading() {
        let tilted = Pose::rotation(Vector3::y() * 0.3);
        let truth = [tilted, yaw(0.5) * tilted];
        let estimate = [tilted, yaw(0.7) * tilted];
        let error = heading_error(&Pairs::by_step(&truth, &estimate).unwrap()).unwrap();
        assert_relative_eq!(error, 0.2 / 2f64.sqrt(), epsilon = 1e-12);
    }

    proptest! {
        #[test]
        fn truth_as_answer_is_exactly_perfect(tangents in proptest::collection::vec(proptest::array::uniform6(-3.0..3.0f64), 1..9)) {
            let truth: Vec<Pose> = tangents.into_iter().map(|t| se3::exp(&Tangent::from(t))).collect();
            prop_assert_eq!(heading_error(&Pairs::by_step(&truth, &truth).unwrap()), Some(0.0));
        }
    }
}
