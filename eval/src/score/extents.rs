//! Error of objects' extents.

use super::pairs::Pairs;
use nalgebra::{UnitQuaternion, Vector3};
use vantage_dataset::ObjectTruth;

/// An estimated ellipsoid, in the estimator's own world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// From its axes to the world.
    pub world_from_axes: UnitQuaternion<f64>,
    /// Its semi-axes, metres.
    pub semi_axes: Vector3<f64>,
}

/// Mean absolute error, metres, of an ellipsoid's half width along each axis of the true object, whose half sides are recorded, once
/// the first estimated robot pose is laid on the first true one. One estimate a true object. `None` where nothing is to be compared.
///
/// Half widths need no axes in common: `sqrt(sum_i (a_i u_i . d)^2)` along `d`, of semi-axes `a_i` along `u_i`.
pub fn extents_error(
    pairs: &Pairs,
    truth: &[ObjectTruth],
    estimates: impl IntoIterator<Item = Option<Ellipsoid>>,
) -> Option<f64> {
    let true_world_from_first = pairs.truth().first().map(|p| p.rotation).unwrap_or_default();
    let first_from_world = pairs.estimate().first().map(|p| p.rotation.inverse()).unwrap_or_default();
    let mut errors = Vec::new();
    for (object, estimate) in truth.iter().zip(estimates) {
        let (Some(known), Some(estimate)) = (object.extents, estimate) else { continue };
        let true_world_from_axes = true_world_from_first * first_from_world * estimate.world_from_axes;
        let axes_from_object = true_world_from_axes.inverse() * object.world_from_object.rotation;
        for (axis, half_side) in known.half_sides.iter().enumerate() {
            let direction = axes_from_object * Vector3::ith(axis, 1.0);
            let half_width = estimate.semi_axes.component_mul(&direction).norm();
            errors.push((half_width - half_side).abs());
        }
    }
    (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::{Extents, InstanceId, Pose, Symmetry};

    #[test]
    fn half_widths_are_compared_along_the_true_axes_whatever_the_frames() {
        let frame = Pose::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.0, 0.3, 1.0));
        let first = Pose::new(Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 0.4));
        let pairs = Pairs::by_step(&[first], &[frame * first]).unwrap();
        let half_sides = Vector3::new(0.1, 0.2, 0.3);
        let object = ObjectTruth {
            instance: InstanceId(1),
            family: "box".to_owned(),
            world_from_object: Pose::new(Vector3::x(), Vector3::new(0.2, -0.1, 0.7)),
            size: 0.8,
            symmetry: Symmetry::None,
            extents: Some(Extents { half_sides, semi_axes: half_sides }),
        };
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let aligned = frame.rotation * object.world_from_object.rotation;
        let error = |world_from_axes, semi_axes| {
            let estimate = Some(Ellipsoid { world_from_axes, semi_axes });
            extents_error(&pairs, std::slice::from_ref(&object), [estimate])
        };
        assert_relative_eq!(error(aligned, half_sides).unwrap(), 0.0, epsilon = 1e-12);
        assert_relative_eq!(
            error(aligned * turn, Vector3::new(0.2, 0.1, 0.3)).unwrap(),
            0.0,
            epsilon = 1e-12
        );
        assert_relative_eq!(error(aligned, Vector3::new(0.1, 0.2, 0.6)).unwrap(), 0.1, epsilon = 1e-12);
        assert_eq!(extents_error(&pairs, std::slice::from_ref(&object), [None]), None);
        let unknown = ObjectTruth { extents: None, ..object };
        let some = Ellipsoid { world_from_axes: aligned, semi_axes: half_sides };
        assert_eq!(extents_error(&pairs, &[unknown], [Some(some)]), None);
    }
}
