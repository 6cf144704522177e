//! The alignment of two point sets in the least-squares sense, with and without scale (Umeyama 1991).

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

/// What lays points on their counterparts with least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// `a_from_b` without scale.
    pub rigid: Pose,
    /// The scale of `b` that leaves least.
    pub scale: f64,
    /// `a_from_b` of points that were scaled by it.
    pub scaled: Pose,
    /// How far the points spread along their line, squared: the largest singular value of their covariance.
    pub along: f64,
    /// Likewise, across it, less what a reflection would take. What a turn about the line by `t` adds to half the mean squared residual is
    /// this times `1 - cos t`: at 0 all turns are as good.
    pub across: f64,
}

/// A rigid transform `T` of least `sum |x_in_a - T x_in_b|^2`: one of many that are as good where the points lie on a line or in one
/// place. `None` for no points, and for points that are not finite.
///
/// # Panics
/// If the sets differ in size.
pub fn umeyama(in_a: &[Vector3<f64>], in_b: &[Vector3<f64>]) -> Option<Pose> {
    Some(similarity(in_a, in_b)?.rigid)
}

/// Likewise, with the scale.
///
/// # Panics
/// If the sets differ in size.
pub fn similarity(in_a: &[Vector3<f64>], in_b: &[Vector3<f64>]) -> Option<Similarity> {
    assert_eq!(in_a.len(), in_b.len(), "each point needs its counterpart");
    let n = in_a.len() as f64;
    // Means, Eq. 34 and 35; variance, Eq. 36; covariance, Eq. 38.
    let mean_a = in_a.iter().sum::<Vector3<f64>>() / n;
    let mean_b = in_b.iter().sum::<Vector3<f64>>() / n;
    let variance = in_b.iter().map(|b| (b - mean_b).norm_squared()).sum::<f64>() / n;
    let covariance: Matrix3<f64> =
        in_a.iter().zip(in_b).map(|(a, b)| (a - mean_a) * (b - mean_b).transpose()).sum::<Matrix3<f64>>() / n;
    if !covariance.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = covariance.svd(true, true);
    let (u, v_transposed) = (svd.u?, svd.v_t?);
    let values = svd.singular_values;
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    // S, Eq. 43: a reflection is undone along the weakest axis.
    let mut s = Matrix3::identity();
    if u.determinant() * v_transposed.determinant() < 0.0 {
        s[(order[2], order[2])] = -1.0;
    }
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(u * s * v_transposed));
    // Eq. 42 and 41.
    let scale = (Matrix3::from_diagonal(&values) * s).trace() / variance;
    let laid = |scale: f64| Pose::from_parts((mean_a - rotation * mean_b * scale).into(), rotation);
    let [along, second, third] = order.map(|i| values[i]);
    let across = second + s[(order[2], order[2])] * third;
    Some(Similarity { rigid: laid(1.0), scale, scaled: laid(scale), along, across })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use vantage_dataset::{Seed, Tangent, se3};

    const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.3, 0.0]];

    proptest! {
        #[test]
        fn a_rigid_transform_is_found_again_even_for_planar_points(t in proptest::array::uniform6(-3.0..3.0f64)) {
            let a_from_b = se3::exp(&Tangent::from(t));
            let in_b: Vec<Vector3<f64>> = POINTS.iter().map(|p| Vector3::from(*p)).collect();
            let in_a: Vec<Vector3<f64>> =
                in_b.iter().map(|p| a_from_b.transform_point(&(*p).into()).coords).collect();
            let found = umeyama(&in_a, &in_b).unwrap();
            assert_relative_eq!(found.to_homogeneous(), a_from_b.to_homogeneous(), epsilon = 1e-9);
        }
    }

    #[test]
    fn a_turn_about_the_line_costs_what_is_promised() {
        let mut stream = Seed(1).stream("points", 0);
        let mut point = |spread: [f64; 3]| Vector3::from(spread.map(|s| s * stream.normal()));
        let in_b: Vec<Vector3<f64>> = (0..40).map(|_| point([5.0, 0.3, 0.1])).collect();
        let in_a: Vec<Vector3<f64>> = in_b.iter().map(|p| p + point([0.02; 3])).collect();
        let found = similarity(&in_a, &in_b).unwrap();
        let cost = |turn: f64| {
            let center = in_a.iter().sum::<Vector3<f64>>() / 40.0;
            let about_x = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), turn);
            let residual = |(a, b): (&Vector3<f64>, &Vector3<f64>)| {
                let laid = found.rigid.transform_point(&(*b).into()).coords;
                (a - center - about_x * (laid - center)).norm_squared()
            };
            in_a.iter().zip(&in_b).map(residual).sum::<f64>() / 80.0
        };
        for turn in [0.5f64, 2.0, 3.0] {
            let promised = found.across * (1.0 - libm::cos(turn));
            assert_relative_eq!(cost(turn) - cost(0.0), promised, max_relative = 0.1);
        }
        assert_relative_eq!(found.along, 25.0, max_relative = 0.5);
        // Of points in a plane, and of their mirror image.
        let flat = |turned: f64| Vector3::new(0.0, turned, 0.0);
        let plane = [Vector3::x(), -Vector3::x(), flat(0.5), flat(-0.5)];
        assert_relative_eq!(similarity(&plane, &plane).unwrap().across, 0.125, epsilon = 1e-12);
    }

    #[test]
    fn a_line_or_a_single_place_is_laid_on_itself_at_any_scale() {
        let a_from_b = se3::exp(&Tangent::from([0.3, -1.0, 2.0, 0.4, -0.8, 1.9]));
        for scale in [1e-6, 1.0, 1e6] {
            let line = |i: u32| Vector3::new(0.3, -1.0, 2.0) * scale * f64::from(i);
            let place = |_| Vector3::new(scale, 0.0, 0.0);
            for in_b in [(0..5).map(line).collect::<Vec<_>>(), (0..4).map(place).collect()] {
                let in_a: Vec<_> =
                    in_b.iter().map(|p| a_from_b.transform_point(&(*p).into()).coords).collect();
                let found = umeyama(&in_a, &in_b).unwrap();
                for (a, b) in in_a.iter().zip(&in_b) {
                    let moved = found.transform_point(&(*b).into()).coords;
                    assert_relative_eq!(moved, *a, epsilon = 1e-9 * scale.max(1.0));
                }
            }
        }
        assert_eq!(umeyama(&[], &[]), None);
    }
}
