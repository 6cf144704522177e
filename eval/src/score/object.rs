//! Object errors: where the map's objects are, and how they are turned.

use super::pairs::Pairs;
use super::{angle_between, root_mean_square};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{ObjectTruth, Symmetry};

/// What an estimator says of one object, in its own world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectEstimate {
    /// Its centre, metres.
    pub center_in_world: Point3<f64>,
    /// `world_from_object`, or `None` where the estimator knows centres only.
    pub rotation: Option<UnitQuaternion<f64>>,
}

/// Errors over the objects of one run, once the first estimated robot pose is laid on the first true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectErrors {
    /// Root mean square distance of the centres, metres; `None` where no object was estimated.
    pub center: Option<f64>,
    /// Root mean square orientation error modulo each object's symmetry, radians; `None` where no orientation
    /// was estimated.
    pub orientation: Option<f64>,
}

/// Scores `estimates`, one a true object (`None`: not in the map), against `truth`.
///
/// # Panics
/// If there is not one entry a true object.
pub fn object_errors(
    pairs: &Pairs,
    truth: &[ObjectTruth],
    estimates: &[Option<ObjectEstimate>],
) -> ObjectErrors {
    assert_eq!(truth.len(), estimates.len(), "each true object needs an entry");
    let first_from_true_world = pairs.truth().first().map(|p| p.inverse()).unwrap_or_default();
    let first_from_world = pairs.estimate().first().map(|p| p.inverse()).unwrap_or_default();
    let (mut centers, mut angles) = (Vec::new(), Vec::new());
    for (object, estimate) in truth.iter().zip(estimates) {
        let Some(estimate) = estimate else { continue };
        let first_from_object = first_from_true_world * object.world_from_object;
        let center = first_from_world * estimate.center_in_world;
        centers.push((center.coords - first_from_object.translation.vector).norm_squared());
        if let Some(rotation) = estimate.rotation {
            let rotation = first_from_world.rotation * rotation;
            angles.push(orientation_error(&first_from_object.rotation, &rotation, object.symmetry).powi(2));
        }
    }
    ObjectErrors {
        center: root_mean_square(centers.into_iter()),
        orientation: root_mean_square(angles.into_iter()),
    }
}

/// The smallest angle, radians, from `estimate` to any rotation that looks like `truth`.
pub fn orientation_error(
    truth: &UnitQuaternion<f64>,
    estimate: &UnitQuaternion<f64>,
    symmetry: Symmetry,
) -> f64 {
    let order = match symmetry {
        Symmetry::None => 1,
        Symmetry::Cyclic { order } => order.max(1),
        Symmetry::Revolution => {
            let (a, b) = (truth * Vector3::z(), estimate * Vector3::z());
            return libm::atan2(a.cross(&b).norm(), a.dot(&b));
        }
    };
    (0..order)
        .map(|turn| {
            let angle = 2.0 * PI * f64::from(turn) / f64::from(order);
            angle_between(&(truth * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)), estimate)
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::{InstanceId, Pose};

    fn about_z(angle: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
    }

    fn object(world_from_object: Pose, symmetry: Symmetry) -> ObjectTruth {
        let (instance, family) = (InstanceId(1), "box".to_owned());
        ObjectTruth { instance, family, world_from_object, size: 0.2, symmetry, extents: None }
    }

    #[test]
    fn orientation_counts_modulo_symmetry() {
        let truth = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.2, 1.0));
        let turned = |angle| truth * about_z(angle);
        let error = |angle, symmetry| orientation_error(&truth, &turned(angle), symmetry);
        assert_relative_eq!(error(3.0, Symmetry::None), 3.0, epsilon = 1e-12);
        assert_relative_eq!(error(3.0, Symmetry::Cyclic { order: 2 }), PI - 3.0, epsilon = 1e-12);
        assert_relative_eq!(error(3.0, Symmetry::Revolution), 0.0, epsilon = 1e-12);
        let tilted = truth * UnitQuaternion::from_scaled_axis(Vector3::x() * 0.25) * about_z(2.0);
        assert_relative_eq!(orientation_error(&truth, &tilted, Symmetry::Revolution), 0.25, epsilon = 1e-12);
    }

    #[test]
    fn errors_are_measured_in_the_frame_of_the_first_robot_pose() {
        let frame = Pose::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.0, 0.3, 1.0));
        let truth = [Pose::new(Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 0.4))];
        let pairs = Pairs::by_step(&truth, &[frame * truth[0]]).unwrap();
        let objects = [
            object(Pose::translation(1.0, 0.0, 0.0), Symmetry::None),
            object(Pose::translation(0.0, 3.0, 0.0), Symmetry::None),
            object(Pose::identity(), Symmetry::None),
        ];
        let estimates = [
            Some(ObjectEstimate {
                center_in_world: frame * Point3::new(1.0, 0.3, 0.0),
                rotation: Some(frame.rotation * about_z(0.1)),
            }),
            Some(ObjectEstimate { center_in_world: frame * Point3::new(0.0, 3.0, 0.4), rotation: None }),
            None,
        ];
        let errors = object_errors(&pairs, &objects, &estimates);
        assert_relative_eq!(errors.center.unwrap(), (0.25f64 / 2.0).sqrt(), epsilon = 1e-12);
        assert_relative_eq!(errors.orientation.unwrap(), 0.1, epsilon = 1e-12);
    }

    #[test]
    fn truth_as_answer_is_exactly_perfect_and_an_empty_map_undefined() {
        let pose = Pose::new(Vector3::new(0.3, 1.0, -2.0), Vector3::new(0.1, 0.0, 0.4));
        let pairs = Pairs::by_step(&[pose], &[pose]).unwrap();
        let objects = [object(Pose::new(Vector3::x(), Vector3::y()), Symmetry::None)];
        let answer = ObjectEstimate {
            center_in_world: objects[0].world_from_object.translation.vector.into(),
            rotation: Some(objects[0].world_from_object.rotation),
        };
        let errors = object_errors(&pairs, &objects, &[Some(answer)]);
        assert_relative_eq!(errors.center.unwrap(), 0.0, epsilon = 1e-15);
        assert_eq!(errors.orientation, Some(0.0));
        let empty = object_errors(&pairs, &objects, &[None]);
        assert_eq!((empty.center, empty.orientation), (None, None));
    }
}
