//! Absolute trajectory error: how far the robot is from where it thinks it is, metres.

use super::align::umeyama;
use super::pairs::Pairs;
use super::root_mean_square;
use nalgebra::Vector3;
use vantage_dataset::Pose;

/// Root mean square of the position error once the first estimated pose is laid on the first true one: the
/// closed rule, under which the gauge of the estimate is fixed by nothing but its start.
///
/// `None` for no pose. The first pose counts, with its error of 0.
pub fn ate(pairs: &Pairs) -> Option<f64> {
    let squares = pairs
        .from_first()
        .map(|(truth, estimate)| (truth.translation.vector - estimate.translation.vector).norm_squared());
    root_mean_square(squares)
}

/// Root mean square of the position error after the best rigid alignment of all positions, as `evo_ape -a`, but also where the positions
/// lie on a line, for which evo may refuse: alignments differ there, but not what is left.
///
/// `None` for no pose.
pub fn ate_umeyama(pairs: &Pairs) -> Option<f64> {
    let truth = positions(pairs.truth());
    let estimate = positions(pairs.estimate());
    let truth_from_estimate = umeyama(&truth, &estimate)?;
    let squares = truth
        .iter()
        .zip(&estimate)
        .map(|(t, e)| (t - truth_from_estimate.transform_point(&(*e).into()).coords).norm_squared());
    root_mean_square(squares)
}

fn positions(poses: &[Pose]) -> Vec<Vector3<f64>> {
    poses.iter().map(|p| p.translation.vector).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use vantage_dataset::{Tangent, se3};

    fn tangent() -> impl Strategy<Value = Tangent> {
        proptest::array::uniform6(-2.0..2.0f64).prop_map(Tangent::from)
    }

    fn track() -> impl Strategy<Value = Vec<Pose>> {
        proptest::collection::vec(tangent().prop_map(|t| se3::exp(&t)), 4..12)
    }

    proptest! {
        #[test]
        fn truth_as_answer_is_exactly_perfect(truth in track()) {
            let pairs = Pairs::by_step(&truth, &truth).unwrap();
            prop_assert_eq!(ate(&pairs), Some(0.0));
            prop_assert!(ate_umeyama(&pairs).unwrap() < 1e-12);
        }

        #[test]
        fn the_frame_of_the_estimate_changes_nothing(truth in track(), noise in tangent(), frame in tangent()) {
            let estimate: Vec<Pose> = truth.iter().enumerate()
                .map(|(i, p)| p * se3::exp(&(noise * (0.01 * i as f64)))).collect();
            let moved: Vec<Pose> = estimate.iter().map(|p| se3::exp(&frame) * p).collect();
            let (here, there) =
                (Pairs::by_step(&truth, &estimate).unwrap(), Pairs::by_step(&truth, &moved).unwrap());
            assert_relative_eq!(ate(&here).unwrap(), ate(&there).unwrap(), epsilon = 1e-10);
            assert_relative_eq!(ate_umeyama(&here).unwrap(), ate_umeyama(&there).unwrap(), epsilon = 1e-10);
            prop_assert!(ate_umeyama(&here).unwrap() <= ate(&here).unwrap() + 1e-12);
        }
    }

    #[test]
    fn a_known_error_is_measured() {
        let truth: Vec<Pose> = (0..4).map(|i| Pose::translation(f64::from(i), 0.0, 0.0)).collect();
        let mut estimate = truth.clone();
        estimate[2] = Pose::translation(2.0, 3.0, 4.0);
        assert_eq!(ate(&Pairs::by_step(&truth, &estimate).unwrap()), Some(2.5));
    }

    #[test]
    fn undefined_is_none_and_one_pose_is_perfect() {
        assert_eq!(ate(&Pairs::by_step(&[], &[]).unwrap()), None);
        let one = Pairs::by_step(&[Pose::identity()], &[Pose::translation(1.0, 0.0, 0.0)]).unwrap();
        assert_eq!((ate(&one), ate_umeyama(&one)), (Some(0.0), Some(0.0)));
    }
}
