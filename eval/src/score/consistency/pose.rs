//! The robot's poses against their covariances.

use super::super::calibration::REGIONS;
use super::super::embedding::Scores;
use super::super::pairs::Pairs;
use super::{Normalized, about, mean};
use crate::result::distribution::chi_squared_cdf;
use crate::result::metric::Metric;
use nalgebra::{Matrix6, Vector3};
use vantage_dataset::se3::log;

/// Numbers of a position's error, and of a heading's.
const POSITION: usize = 3;
const HEADING: usize = 1;

/// NEES / dof of the robot's pose at every step after the first, whose covariance is the gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseConsistency {
    /// Of the whole pose.
    pub pose: Vec<f64>,
    /// Of the position.
    pub position: Vec<f64>,
    /// Of the rotation about the vertical.
    pub heading: Vec<f64>,
    /// `-log N(v; 0, S_v)` of the last position's error, nats.
    pub position_surprise: f64,
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
    let (mut poses, mut positions, mut headings) = (Vec::new(), Vec::new(), Vec::new());
    let mut position_surprise = 0.0;
    for ((truth, estimate), covariance) in pairs.from_first().zip(covariances).skip(1) {
        let xi = log(&estimate.inv_mul(&truth));
        let (omega, v) = (xi.fixed_rows::<3>(0).into_owned(), xi.fixed_rows::<3>(3).into_owned());
        let of_rotation = covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let position = Normalized::of(&v, &covariance.fixed_view::<3, 3>(3, 3).into_owned())?;
        poses.push(Normalized::of(&xi, covariance)?.per_number);
        headings.push(about(&(estimate.rotation.inverse() * up_in_first), &omega, &of_rotation)?.per_number);
        positions.push(position.per_number);
        position_surprise = position.surprise;
    }
    Some(PoseConsistency { pose: poses, position: positions, heading: headings, position_surprise })
}

/// The scores of the robot's poses; none without covariances.
pub fn pose_scores(pairs: &Pairs, covariances: Option<&[Matrix6<f64>]>) -> Scores {
    let found = covariances.and_then(|covariances| pose_consistency(pairs, covariances));
    let Some(PoseConsistency { pose, position, heading, position_surprise }) = found else {
        return Scores::new();
    };
    let [position_50, position_80, position_95] = coverage(&position, POSITION);
    let [heading_50, heading_80, heading_95] = coverage(&heading, HEADING);
    let end = |nees: &[f64]| nees.last().copied();
    let values = [
        (Metric::NeesPositionEnd, end(&position)),
        (Metric::NeesHeadingEnd, end(&heading)),
        (Metric::NeesPoseEnd, end(&pose)),
        (Metric::NeesPosition, mean(&position)),
        (Metric::NeesHeading, mean(&heading)),
        (Metric::NeesPose, mean(&pose)),
        (Metric::PositionInside50, position_50),
        (Metric::PositionInside80, position_80),
        (Metric::PositionInside95, position_95),
        (Metric::HeadingInside50, heading_50),
        (Metric::HeadingInside80, heading_80),
        (Metric::HeadingInside95, heading_95),
        (Metric::PositionSurprise, Some(position_surprise)),
    ];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}

/// The shares of NEES / dof inside the regions that should hold [`REGIONS`]; `None` of none.
fn coverage(nees: &[f64], degrees: usize) -> [Option<f64>; 3] {
    let degrees = degrees as f64;
    REGIONS.map(|region| {
        let inside = nees.iter().filter(|&&nees| chi_squared_cdf(nees * degrees, degrees) <= region).count();
        (!nees.is_empty()).then(|| inside as f64 / nees.len() as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::super::tests::{covariance, draw};
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
        assert_eq!(found.len(), COLUMNS.len() - 2, "all but those of objects");
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
        assert_relative_eq!(found[&Metric::PositionSurprise], surprise, epsilon = 1e-12);
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
