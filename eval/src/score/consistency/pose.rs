//! The robot's poses against their covariances.

use super::super::embedding::Scores;
use super::super::pairs::Pairs;
use super::{Normalized, NormalizedErrors, POSE, about};
use crate::result::metric::Metric;
use nalgebra::{Matrix6, Vector3};
use vantage_dataset::se3::log;

/// Numbers of a position's error, and of a heading's.
const POSITION: usize = 3;
const HEADING: usize = 1;

/// The robot's pose at every step after the first, whose covariance is the gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseConsistency {
    /// Of the whole pose.
    pub pose: NormalizedErrors,
    /// Of the position.
    pub position: NormalizedErrors,
    /// Of the rotation about the vertical.
    pub heading: NormalizedErrors,
}

/// Holds poses against their covariances, of the right perturbation, rotation first.
///
/// Once the first poses are laid on each other, the error of a step is `xi = Log(T_estimate^-1 T_true) = [omega; v]`: `xi` itself of
/// the pose, `v` of the position, and of the heading `u . omega` with the true vertical `u` in the estimated robot's axes.
///
/// `None` for fewer than two poses, without one covariance a pose, or where one after the first is not positive definite.
pub fn pose_consistency(pairs: &Pairs, covariances: &[Matrix6<f64>]) -> Option<PoseConsistency> {
    let up_in_first = pairs.truth().first()?.rotation.inverse() * Vector3::z();
    if covariances.len() != pairs.truth().len() || covariances.len() < 2 {
        return None;
    }
    let [mut pose, mut position, mut heading] = [POSE, POSITION, HEADING].map(NormalizedErrors::of);
    for ((truth, estimate), covariance) in pairs.from_first().zip(covariances).skip(1) {
        let xi = log(&estimate.inv_mul(&truth));
        let (omega, v) = (xi.fixed_rows::<3>(0).into_owned(), xi.fixed_rows::<3>(3).into_owned());
        let of_rotation = covariance.fixed_view::<3, 3>(0, 0).into_owned();
        pose.push(Normalized::of(&xi, covariance)?);
        position.push(Normalized::of(&v, &covariance.fixed_view::<3, 3>(3, 3).into_owned())?);
        heading.push(about(&(estimate.rotation.inverse() * up_in_first), &omega, &of_rotation)?);
    }
    Some(PoseConsistency { pose, position, heading })
}

/// The scores of the robot's poses; none without covariances.
pub fn pose_scores(pairs: &Pairs, covariances: Option<&[Matrix6<f64>]>) -> Scores {
    let found = covariances.and_then(|covariances| pose_consistency(pairs, covariances));
    let Some(PoseConsistency { pose, position, heading }) = found else {
        return Scores::new();
    };
    let [position_50, position_80, position_95] = position.inside();
    let [heading_50, heading_80, heading_95] = heading.inside();
    let [pose_50, pose_80, pose_95] = pose.inside();
    let values = [
        (Metric::NeesPositionEnd, position.nees.last().copied()),
        (Metric::NeesHeadingEnd, heading.nees.last().copied()),
        (Metric::NeesPoseEnd, pose.nees.last().copied()),
        (Metric::NeesPosition, position.mean_nees()),
        (Metric::NeesHeading, heading.mean_nees()),
        (Metric::NeesPose, pose.mean_nees()),
        (Metric::PositionSurpriseEnd, position.surprise.last().copied()),
        (Metric::HeadingSurpriseEnd, heading.surprise.last().copied()),
        (Metric::PoseSurpriseEnd, pose.surprise.last().copied()),
        (Metric::PositionSurprise, position.mean_surprise()),
        (Metric::HeadingSurprise, heading.mean_surprise()),
        (Metric::PoseSurprise, pose.mean_surprise()),
        (Metric::PositionInside50, position_50),
        (Metric::PositionInside80, position_80),
        (Metric::PositionInside95, position_95),
        (Metric::HeadingInside50, heading_50),
        (Metric::HeadingInside80, heading_80),
        (Metric::HeadingInside95, heading_95),
        (Metric::PoseInside50, pose_50),
        (Metric::PoseInside80, pose_80),
        (Metric::PoseInside95, pose_95),
    ];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{covariance, draw};
    use super::super::{COLUMNS, INSIDE};
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;
    use vantage_dataset::{Pose, Seed, Tangent, se3};

    const STEPS: usize = 4000;

    /// An estimate, and a truth that is off by draws of a Gaussian from the second step on; covariances are that Gaussian's times `told`.
    fn drawn(told: f64) -> (Vec<Pose>, Vec<Pose>, Vec<Matrix6<f64>>) {
        let (mut stream, covariance) = (Seed(2).stream("draws", 0), covariance());
        let level =
            |i: usize| Pose::new(Vector3::new(0.01 * i as f64, 1.0, 0.3), Vector3::z() * 0.1 * i as f64);
        let estimate: Vec<Pose> = (0..STEPS).map(level).collect();
        let off = |(i, pose): (usize, &Pose)| {
            if i == 0 { *pose } else { pose * se3::exp(&draw(&covariance, &mut stream)) }
        };
        let truth = estimate.iter().enumerate().map(off).collect();
        let mut covariances = vec![covariance * told; STEPS];
        covariances[0] = Matrix6::identity() * 1e-12;
        (truth, estimate, covariances)
    }

    fn scores(truth: &[Pose], estimate: &[Pose], covariances: &[Matrix6<f64>]) -> Scores {
        pose_scores(&Pairs::by_step(truth, estimate).unwrap(), Some(covariances))
    }

    #[test]
    fn draws_of_the_stated_gaussian_are_consistent_and_fill_its_regions() {
        let (truth, estimate, covariances) = drawn(1.0);
        let found = scores(&truth, &estimate, &covariances);
        assert_eq!(found.len(), COLUMNS.len() + INSIDE.len() - 10, "all but those of objects");
        for metric in [Metric::NeesPose, Metric::NeesPosition, Metric::NeesHeading] {
            assert_relative_eq!(found[&metric], 1.0, epsilon = 0.05);
        }
        for (metric, share) in [
            (Metric::PositionInside50, 0.5),
            (Metric::PositionInside80, 0.8),
            (Metric::PositionInside95, 0.95),
            (Metric::HeadingInside50, 0.5),
            (Metric::HeadingInside80, 0.8),
            (Metric::HeadingInside95, 0.95),
            (Metric::PoseInside50, 0.5),
            (Metric::PoseInside80, 0.8),
            (Metric::PoseInside95, 0.95),
        ] {
            assert_relative_eq!(found[&metric], share, epsilon = 0.02);
        }
    }

    #[test]
    fn a_covariance_four_times_too_small_makes_it_four() {
        let ((truth, estimate, small), (.., right)) = (drawn(0.25), drawn(1.0));
        let (small, right) = (scores(&truth, &estimate, &small), scores(&truth, &estimate, &right));
        for metric in COLUMNS[..6].iter() {
            assert_relative_eq!(small[metric], 4.0 * right[metric], max_relative = 1e-9);
        }
        assert!(small[&Metric::PositionInside95] < 0.6, "{small:?}");
    }

    #[test]
    fn the_estimates_frame_changes_nothing() {
        let (truth, estimate, covariances) = drawn(1.0);
        let frame = Pose::new(Vector3::new(3.0, -1.0, 2.0), Vector3::new(0.4, -0.2, 2.0));
        let moved: Vec<Pose> = estimate.iter().map(|pose| frame * pose).collect();
        let (here, there) = (scores(&truth, &estimate, &covariances), scores(&truth, &moved, &covariances));
        assert_eq!(here.len(), there.len());
        for (metric, value) in here {
            assert_relative_eq!(value, there[&metric], max_relative = 1e-8);
        }
    }

    #[test]
    fn known_errors_have_known_scores() {
        let truth = [Pose::identity(), Pose::new(Vector3::new(0.0, 0.3, 0.0), Vector3::zeros())];
        let covariances = [Matrix6::identity() * 1e-12, Matrix6::identity() * 0.04];
        let found = scores(&truth, &[Pose::identity(); 2], &covariances);
        assert_relative_eq!(found[&Metric::NeesPositionEnd], 0.75, epsilon = 1e-12);
        assert_relative_eq!(found[&Metric::NeesPose], 0.375, epsilon = 1e-12);
        assert_eq!(found[&Metric::NeesHeading], 0.0);
        let surprise = 1.5 * libm::log(2.0 * PI * 0.04) + 2.25 / 2.0;
        assert_relative_eq!(found[&Metric::PositionSurpriseEnd], surprise, epsilon = 1e-12);
        assert_eq!(found[&Metric::PositionSurprise], found[&Metric::PositionSurpriseEnd], "of one step");
        let of_heading = 0.5 * libm::log(2.0 * PI * 0.04);
        assert_relative_eq!(found[&Metric::HeadingSurpriseEnd], of_heading, epsilon = 1e-12);
        let of_pose = 3.0 * libm::log(2.0 * PI * 0.04) + 2.25 / 2.0;
        assert_relative_eq!(found[&Metric::PoseSurprise], of_pose, epsilon = 1e-12);
        // P(chi^2(3) <= 2.25) = 0.478
        assert_eq!((found[&Metric::PositionInside50], found[&Metric::HeadingInside50]), (1.0, 1.0));
        let turned = [Pose::identity(), Pose::rotation(Vector3::z() * 0.5)];
        let found = scores(&turned, &[Pose::identity(); 2], &covariances);
        assert_relative_eq!(found[&Metric::NeesHeadingEnd], 6.25, epsilon = 1e-12);
        assert_eq!(found[&Metric::HeadingInside95], 0.0);
    }

    #[test]
    fn heading_is_about_the_vertical_whatever_way_up_the_robot_is() {
        let lying = Pose::rotation(Vector3::x() * PI / 2.0);
        let turned = Pose::rotation(Vector3::z() * 0.3) * lying;
        let variances = Tangent::new(4.0, 0.09, 4.0, 1.0, 1.0, 1.0);
        let covariances = [Matrix6::identity(), Matrix6::from_diagonal(&variances)];
        let found = scores(&[lying, turned], &[lying, lying], &covariances);
        assert_relative_eq!(found[&Metric::NeesHeadingEnd], 1.0, epsilon = 1e-12);
    }

    #[test]
    fn without_a_covariance_or_with_a_singular_one_there_is_no_score() {
        let (truth, estimate, covariances) = drawn(1.0);
        let pairs = Pairs::by_step(&truth, &estimate).unwrap();
        assert_eq!(pose_scores(&pairs, None), Scores::new());
        let vector = Tangent::from_fn(|i, _| 1.0 + i as f64);
        for bad in [Matrix6::zeros(), vector * vector.transpose(), -covariance(), covariance() * f64::NAN] {
            let mut some = covariances.clone();
            some[70] = bad;
            assert_eq!(pose_scores(&pairs, Some(&some)), Scores::new(), "{bad}");
        }
        assert_eq!(pose_scores(&pairs, Some(&covariances[1..])), Scores::new());
        let first = Pairs::by_step(&truth[..1], &estimate[..1]).unwrap();
        assert_eq!(pose_scores(&first, Some(&covariances[..1])), Scores::new());
    }
}
