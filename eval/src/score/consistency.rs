//! Consistency: whether errors are as large as the estimator's own covariances say.
//!
//! The normalized estimation error squared (NEES) of an error `e` of `n` numbers under its covariance `S` is `e^T S^-1 e` (Bar-Shalom, Li and
//! Kirubarajan 2001, 5.4.2). Of a consistent estimator it follows the chi-square law with `n` degrees of freedom, so that NEES / n is
//! 1 in the mean. Above 1 the estimator promises too much.

use super::calibration::REGIONS;
use super::embedding::Scores;
use super::pairs::Pairs;
use crate::result::distribution::chi_squared_cdf;
use crate::result::metric::Metric;
use nalgebra::{Matrix3, Matrix6, Point3, SMatrix, SVector, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use vantage_dataset::se3::{log, so3_log};
use vantage_dataset::{ObjectTruth, Symmetry};

/// The name of the table of consistency.
pub const CONSISTENCY: &str = "consistency";
/// Its columns.
pub const COLUMNS: [Metric; 15] = [
    Metric::NeesPositionEnd,
    Metric::NeesHeadingEnd,
    Metric::NeesPoseEnd,
    Metric::NeesPosition,
    Metric::NeesHeading,
    Metric::NeesPose,
    Metric::NeesObjectCenter,
    Metric::NeesObjectYaw,
    Metric::PositionInside50,
    Metric::PositionInside80,
    Metric::PositionInside95,
    Metric::HeadingInside50,
    Metric::HeadingInside80,
    Metric::HeadingInside95,
    Metric::PositionSurprise,
];

/// Numbers of a pose's error, of a position's, and of a heading's.
pub const POSE: usize = 6;
const POSITION: usize = 3;
const HEADING: usize = 1;

/// Below this share of its variance that its correlations leave to a number, a covariance is singular to rounding.
const SINGULAR: f64 = 1e-10;
/// Variance of an angle of which nothing is known, radians squared.
const UNIFORM_ANGLE: f64 = PI * PI / 3.0;

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

/// What an estimator says of one object, in its own world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectGaussian {
    /// Its centre, metres.
    pub center_in_world: Point3<f64>,
    /// Covariance of the centre, world axes.
    pub center_covariance: Option<Matrix3<f64>>,
    /// `world_from_object`, where the estimator knows it.
    pub rotation: Option<UnitQuaternion<f64>>,
    /// Covariance of the rotation's right perturbation.
    pub rotation_covariance: Option<Matrix3<f64>>,
}

/// NEES / dof of the objects' centres and, where they are `oriented` as the truth's, of their rotation about the vertical, each the mean over the
/// objects of one run; one estimate a true object, `None` of one that is not in the map.
///
/// The yaw of symmetric objects is left out, and one of which no more is promised than of any angle. A score is absent without
/// objects, or where one of them has no covariance that is positive definite.
pub fn object_scores(
    pairs: &Pairs,
    truth: &[ObjectTruth],
    objects: &[Option<ObjectGaussian>],
    oriented: bool,
) -> Scores {
    let world_from_true_world = pairs.true_world_from_estimate_world().inverse();
    let up = world_from_true_world.rotation * Vector3::z();
    let (mut centers, mut yaws) = (Vec::new(), Vec::new());
    for (true_object, object) in truth.iter().zip(objects) {
        let Some(object) = object else { continue };
        let world_from_object = world_from_true_world * true_object.world_from_object;
        let error = world_from_object.translation.vector - object.center_in_world.coords;
        centers.push(object.center_covariance.and_then(|s| Some(Normalized::of(&error, &s)?.per_number)));
        let Some(rotation) = object.rotation.filter(|_| true_object.symmetry == Symmetry::None) else {
            continue;
        };
        let (axis, covariance) = (rotation.inverse() * up, object.rotation_covariance);
        if covariance.is_some_and(|s| variance_about(&axis, &s) >= UNIFORM_ANGLE) {
            continue;
        }
        let omega = so3_log(&(rotation.inverse() * world_from_object.rotation));
        yaws.push(covariance.and_then(|s| Some(about(&axis, &omega, &s)?.per_number)));
    }
    let all = |nees: Vec<Option<f64>>| mean(&nees.into_iter().collect::<Option<Vec<f64>>>()?);
    let values =
        [(Metric::NeesObjectCenter, all(centers)), (Metric::NeesObjectYaw, all(yaws).filter(|_| oriented))];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}

/// An error against its covariance.
struct Normalized {
    /// NEES over the error's numbers.
    per_number: f64,
    /// `-log N(e; 0, S)`, nats.
    surprise: f64,
}

impl Normalized {
    /// `None` where the covariance is not finite and positive definite, or the error not finite.
    fn of<const N: usize>(error: &SVector<f64, N>, covariance: &SMatrix<f64, N, N>) -> Option<Self> {
        let deviations = covariance.diagonal().map(f64::sqrt);
        let correlations =
            SMatrix::<f64, N, N>::from_fn(|i, j| covariance[(i, j)] / (deviations[i] * deviations[j]));
        let root = correlations.cholesky()?.l();
        if root.diagonal().iter().any(|left| !(left * left > SINGULAR)) {
            return None;
        }
        let squared = root.solve_lower_triangular(&error.component_div(&deviations))?.norm_squared();
        let log_determinant: f64 = (0..N).map(|i| 2.0 * libm::log(root[(i, i)] * deviations[i])).sum();
        let surprise = (squared + log_determinant + N as f64 * libm::log(2.0 * PI)) / 2.0;
        surprise.is_finite().then_some(Self { per_number: squared / N as f64, surprise })
    }
}

/// The part of a rotation's error about an axis.
fn about(axis: &Vector3<f64>, omega: &Vector3<f64>, covariance: &Matrix3<f64>) -> Option<Normalized> {
    Normalized::of(&SVector::from([axis.dot(omega)]), &SMatrix::from([[variance_about(axis, covariance)]]))
}

fn variance_about(axis: &Vector3<f64>, covariance: &Matrix3<f64>) -> f64 {
    axis.dot(&(covariance * axis))
}

/// The shares of NEES / dof inside the regions that should hold [`REGIONS`]; `None` of none.
fn coverage(nees: &[f64], degrees: usize) -> [Option<f64>; 3] {
    let degrees = degrees as f64;
    REGIONS.map(|region| {
        let inside = nees.iter().filter(|&&nees| chi_squared_cdf(nees * degrees, degrees) <= region).count();
        (!nees.is_empty()).then(|| inside as f64 / nees.len() as f64)
    })
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::seed::Stream;
    use vantage_dataset::{InstanceId, Pose, Seed, Tangent, se3};

    const STEPS: usize = 4000;

    fn draw<const N: usize>(covariance: &SMatrix<f64, N, N>, stream: &mut Stream) -> SVector<f64, N> {
        covariance.cholesky().unwrap().l() * SVector::from_fn(|_, _| stream.normal())
    }

    /// Correlated, of a few hundredths of radians and metres.
    fn covariance() -> Matrix6<f64> {
        let mut stream = Seed(1).stream("covariance", 0);
        let root = Matrix6::from_fn(|_, _| 0.02 * stream.normal());
        root * root.transpose() + Matrix6::identity() * 1e-4
    }

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

    fn objects(frame: &Pose, told: f64) -> (Vec<ObjectTruth>, Vec<Option<ObjectGaussian>>) {
        let mut stream = Seed(3).stream("objects", 0);
        let of_center = covariance().fixed_view::<3, 3>(3, 3).into_owned();
        let of_rotation = covariance().fixed_view::<3, 3>(0, 0).into_owned();
        let axes = frame.rotation.to_rotation_matrix().into_inner();
        let object = |i: usize| {
            let center = Vector3::new(0.1 * i as f64, 2.0, 1.0);
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.2 * i as f64);
            let world_from_object = Pose::from_parts(
                (center + draw(&of_center, &mut stream)).into(),
                rotation * se3::so3_exp(&draw(&of_rotation, &mut stream)),
            );
            let (instance, family, symmetry) = (InstanceId(i as u64), "mug".to_owned(), Symmetry::None);
            let truth =
                ObjectTruth { instance, family, world_from_object, size: 0.2, symmetry, extents: None };
            let estimate = ObjectGaussian {
                center_in_world: frame * Point3::from(center),
                center_covariance: Some(axes * of_center * axes.transpose() * told),
                rotation: Some(frame.rotation * rotation),
                rotation_covariance: Some(of_rotation * told),
            };
            (truth, Some(estimate))
        };
        (0..3000).map(object).unzip()
    }

    #[test]
    fn objects_of_the_stated_gaussian_are_consistent_in_any_frame() {
        let frame = Pose::new(Vector3::new(3.0, -1.0, 2.0), Vector3::new(0.4, -0.2, 2.0));
        let pairs = Pairs::by_step(&[Pose::identity()], &[frame]).unwrap();
        for (told, nees) in [(1.0, 1.0), (0.25, 4.0)] {
            let (truth, estimates) = objects(&frame, told);
            let found = object_scores(&pairs, &truth, &estimates, true);
            assert_relative_eq!(found[&Metric::NeesObjectCenter], nees, max_relative = 0.05);
            assert_relative_eq!(found[&Metric::NeesObjectYaw], nees, max_relative = 0.08);
        }
    }

    #[test]
    fn yaws_that_nobody_shares_or_promises_are_left_out_and_singular_ones_undefine_the_score() {
        let pairs = Pairs::by_step(&[Pose::identity()], &[Pose::identity()]).unwrap();
        let (mut truth, mut estimates) = objects(&Pose::identity(), 1.0);
        (truth.truncate(2), estimates.truncate(2));
        let scores = |truth: &[ObjectTruth], estimates: &[Option<ObjectGaussian>], oriented| {
            let found = object_scores(&pairs, truth, estimates, oriented);
            [Metric::NeesObjectCenter, Metric::NeesObjectYaw].map(|metric| found.get(&metric).copied())
        };
        let [center, _] = scores(&truth, &estimates, true);
        assert_eq!(scores(&truth, &estimates, false), [center, None]);
        let [_, first] = scores(&truth[..1], &estimates[..1], true);
        assert!(center.is_some() && first.is_some());
        for symmetry in [Symmetry::Cyclic { order: 2 }, Symmetry::Revolution] {
            truth[1].symmetry = symmetry;
            assert_eq!(scores(&truth, &estimates, true), [center, first]);
        }
        truth[1].symmetry = Symmetry::None;
        let with_rotation = |covariance: Option<Matrix3<f64>>| {
            let mut estimates = estimates.clone();
            estimates[1].as_mut().unwrap().rotation_covariance = covariance;
            scores(&truth, &estimates, true)
        };
        assert_eq!(with_rotation(Some(Matrix3::identity() * 1e6)), [center, first]);
        assert_eq!(with_rotation(Some(Matrix3::zeros())), [center, None]);
        assert_eq!(with_rotation(None), [center, None]);
        estimates[0].as_mut().unwrap().center_covariance = None;
        assert_eq!(scores(&truth, &estimates, true)[0], None);
        assert_eq!(scores(&truth, &[None, None], true), [None, None]);
    }
}
