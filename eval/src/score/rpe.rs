//! Relative pose error over one step: how far the motion is from what the robot thinks it was.

use super::pairs::Pairs;
use super::{angle_between, root_mean_square};
use vantage_dataset::Pose;

/// Root mean squares over consecutive steps; `None` below two poses. Needs no alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rpe {
    /// Of the translation, metres.
    pub translation: Option<f64>,
    /// Of the rotation angle, radians.
    pub rotation: Option<f64>,
}

/// `E = (Q_i^-1 Q_{i+1})^-1 (P_i^-1 P_{i+1})` with true `Q` and estimated `P`: evo's RPE at a delta of 1 frame.
pub fn rpe(pairs: &Pairs) -> Rpe {
    let step = |poses: &[Pose]| poses[0].inverse() * poses[1];
    let truth: Vec<Pose> = pairs.truth().windows(2).map(step).collect();
    let estimate: Vec<Pose> = pairs.estimate().windows(2).map(step).collect();
    let steps = || truth.iter().zip(&estimate);
    Rpe {
        translation: root_mean_square(
            steps().map(|(t, e)| (t.translation.vector - e.translation.vector).norm_squared()),
        ),
        rotation: root_mean_square(steps().map(|(t, e)| angle_between(&t.rotation, &e.rotation).powi(2))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use vantage_dataset::{Tangent, se3};

    #[test]
    fn known_errors_are_measured() {
        let truth = [Pose::identity(), Pose::translation(1.0, 0.0, 0.0), Pose::translation(2.0, 0.0, 0.0)];
        let estimate =
            [truth[0], truth[1], Pose::new(Vector3::new(2.0, 0.2, 0.0), Vector3::new(0.0, 0.1, 0.0))];
        let rpe = rpe(&Pairs::by_step(&truth, &estimate).unwrap());
        assert_relative_eq!(rpe.translation.unwrap(), 0.2 / 2f64.sqrt(), epsilon = 1e-12);
        assert_relative_eq!(rpe.rotation.unwrap(), 0.1 / 2f64.sqrt(), epsilon = 1e-12);
    }

    #[test]
    fn one_pose_has_no_motion() {
        let one = Pairs::by_step(&[Pose::identity()], &[Pose::identity()]).unwrap();
        assert_eq!(rpe(&one), Rpe { translation: None, rotation: None });
    }

    proptest! {
        #[test]
        fn truth_as_answer_is_exactly_perfect(tangents in proptest::collection::vec(proptest::array::uniform6(-3.0..3.0f64), 2..9)) {
            let truth: Vec<Pose> = tangents.into_iter().map(|t| se3::exp(&Tangent::from(t))).collect();
            let perfect = Rpe { translation: Some(0.0), rotation: Some(0.0) };
            prop_assert_eq!(rpe(&Pairs::by_step(&truth, &truth).unwrap()), perfect);
        }
    }
}
