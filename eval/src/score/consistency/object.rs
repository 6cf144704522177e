//! Objects' centres and yaws against their covariances.

use super::super::embedding::Scores;
use super::super::pairs::Pairs;
use super::{Normalized, NormalizedErrors, about, variance_about};
use crate::result::metric::Metric;
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use vantage_dataset::se3::so3_log;
use vantage_dataset::{ObjectTruth, Symmetry};

/// Numbers of a centre's error, and of a yaw's.
const CENTER: usize = 3;
const YAW: usize = 1;

/// Variance of an angle of which nothing is known, radians squared.
const UNIFORM_ANGLE: f64 = PI * PI / 3.0;

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

/// NEES / dof, negative log-likelihoods and shares inside regions of the objects' centres and, where they are `oriented` as the truth's, of their
/// rotation about the vertical, each over the objects of one run; one estimate a true object, `None` of one that is not in the map.
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
        centers.push(object.center_covariance.and_then(|s| Normalized::of(&error, &s)));
        let Some(rotation) = object.rotation.filter(|_| true_object.symmetry == Symmetry::None) else {
            continue;
        };
        let (axis, covariance) = (rotation.inverse() * up, object.rotation_covariance);
        if covariance.is_some_and(|s| variance_about(&axis, &s) >= UNIFORM_ANGLE) {
            continue;
        }
        let omega = so3_log(&(rotation.inverse() * world_from_object.rotation));
        yaws.push(covariance.and_then(|s| about(&axis, &omega, &s)));
    }
    let center = all(CENTER, centers);
    let yaw = all(YAW, yaws).filter(|_| oriented);
    let [center_50, center_80, center_95] = center.as_ref().map_or([None; 3], NormalizedErrors::inside);
    let [yaw_50, yaw_80, yaw_95] = yaw.as_ref().map_or([None; 3], NormalizedErrors::inside);
    let (center, yaw) = (center.as_ref(), yaw.as_ref());
    let values = [
        (Metric::NeesObjectCenter, center.and_then(NormalizedErrors::mean_nees)),
        (Metric::NeesObjectYaw, yaw.and_then(NormalizedErrors::mean_nees)),
        (Metric::ObjectCenterSurprise, center.and_then(NormalizedErrors::mean_surprise)),
        (Metric::ObjectYawSurprise, yaw.and_then(NormalizedErrors::mean_surprise)),
        (Metric::ObjectCenterInside50, center_50),
        (Metric::ObjectCenterInside80, center_80),
        (Metric::ObjectCenterInside95, center_95),
        (Metric::ObjectYawInside50, yaw_50),
        (Metric::ObjectYawInside80, yaw_80),
        (Metric::ObjectYawInside95, yaw_95),
    ];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}

/// All errors, of so many numbers each; `None` where one has no covariance that is positive definite.
fn all(degrees: usize, errors: Vec<Option<Normalized>>) -> Option<NormalizedErrors> {
    let mut all = NormalizedErrors::of(degrees);
    for error in errors {
        all.push(error?);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{covariance, draw};
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::{InstanceId, Pose, Seed, se3};

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
        let mut surprises = Vec::new();
        let frame = Pose::new(Vector3::new(3.0, -1.0, 2.0), Vector3::new(0.4, -0.2, 2.0));
        let pairs = Pairs::by_step(&[Pose::identity()], &[frame]).unwrap();
        for (told, nees) in [(1.0, 1.0), (0.25, 4.0)] {
            let (truth, estimates) = objects(&frame, told);
            let found = object_scores(&pairs, &truth, &estimates, true);
            assert_relative_eq!(found[&Metric::NeesObjectCenter], nees, max_relative = 0.05);
            assert_relative_eq!(found[&Metric::NeesObjectYaw], nees, max_relative = 0.08);
            let inside = [
                (Metric::ObjectCenterInside50, Metric::ObjectYawInside50, 0.5),
                (Metric::ObjectCenterInside80, Metric::ObjectYawInside80, 0.8),
                (Metric::ObjectCenterInside95, Metric::ObjectYawInside95, 0.95),
            ];
            for (center, yaw, share) in inside {
                let is_right = |metric| (found[&metric] - share).abs() < 0.025;
                assert_eq!((is_right(center), is_right(yaw)), (nees == 1.0, nees == 1.0), "{share}");
            }
            surprises.push([Metric::ObjectCenterSurprise, Metric::ObjectYawSurprise].map(|of| found[&of]));
        }
        // (4 n + log |S| - n log 4) / 2 less (n + log |S|) / 2.
        let worse = |numbers: f64| numbers * (3.0 - 2.0 * std::f64::consts::LN_2) / 2.0;
        for (kind, numbers) in [CENTER, YAW].into_iter().enumerate() {
            let found = surprises[1][kind] - surprises[0][kind];
            assert_relative_eq!(found, worse(numbers as f64), max_relative = 0.1);
        }
    }

    #[test]
    fn yaws_that_nobody_shares_or_promises_are_left_out_and_singular_ones_undefine_the_score() {
        let pairs = Pairs::by_step(&[Pose::identity()], &[Pose::identity()]).unwrap();
        let (mut truth, mut estimates) = objects(&Pose::identity(), 1.0);
        truth.truncate(2);
        estimates.truncate(2);
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
