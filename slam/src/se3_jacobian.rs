//! The inverse right Jacobian of SE(3): how `Log` moves when its argument is perturbed on the right.

use nalgebra::{Matrix3, Matrix6};
use vantage_dataset::Tangent;
use vantage_dataset::se3::{hat, so3_left_jacobian_inverse};

const SMALL_ANGLE_SQUARED: f64 = 1e-3;

/// `J_r^-1(xi)` with `Log(Exp(xi) Exp(delta)) = xi + J_r^-1(xi) delta` to first order.
pub fn right_jacobian_inverse(xi: &Tangent) -> Matrix6<f64> {
    left_jacobian_inverse(&-xi)
}

/// `J_l^-1(xi)` with `Log(Exp(delta) Exp(xi)) = xi + J_l^-1(xi) delta` to first order.
///
/// Barfoot, State Estimation for Robotics (2017), Eq. 7.95, in the order rotation, translation.
pub fn left_jacobian_inverse(xi: &Tangent) -> Matrix6<f64> {
    let omega = xi.fixed_rows::<3>(0).into_owned();
    let j_inverse = so3_left_jacobian_inverse(&omega);
    let mut inverse = Matrix6::zeros();
    inverse.fixed_view_mut::<3, 3>(0, 0).copy_from(&j_inverse);
    inverse.fixed_view_mut::<3, 3>(3, 3).copy_from(&j_inverse);
    inverse.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-j_inverse * translation_block(xi) * j_inverse));
    inverse
}

/// The block `Q` of the left Jacobian (Barfoot, Eq. 7.86b): `d translation / d rotation`.
fn translation_block(xi: &Tangent) -> Matrix3<f64> {
    let omega = xi.fixed_rows::<3>(0).into_owned();
    let w = hat(&omega);
    let v = hat(&xi.fixed_rows::<3>(3).into_owned());
    let t2 = omega.norm_squared();
    let (a, b, c) = if t2 < SMALL_ANGLE_SQUARED {
        (
            1.0 / 6.0 - t2 / 120.0 + t2 * t2 / 5040.0,
            1.0 / 24.0 - t2 / 720.0 + t2 * t2 / 40320.0,
            1.0 / 120.0 - t2 / 2520.0 + t2 * t2 / 120_960.0,
        )
    } else {
        let t = t2.sqrt();
        let (sin, cos) = (libm::sin(t), libm::cos(t));
        (
            (t - sin) / (t2 * t),
            (t2 + 2.0 * cos - 2.0) / (2.0 * t2 * t2),
            (2.0 * t - 3.0 * sin + t * cos) / (2.0 * t2 * t2 * t),
        )
    };
    let wv = w * v;
    let vw = v * w;
    let wvw = wv * w;
    v * 0.5 + (wv + vw + wvw) * a + (w * wv + vw * w - wvw * 3.0) * b + (wvw * w + w * wvw) * c
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use std::f64::consts::PI;
    use vantage_dataset::se3;

    #[test]
    fn matches_central_differences_of_the_logarithm() {
        for angle in [0.0, 1e-9, 1e-3, 0.031, 0.032, 0.5, 2.0, PI - 1e-3] {
            for axis in [Vector3::x(), Vector3::new(0.6, 0.0, -0.8), Vector3::new(-0.48, 0.6, 0.64)] {
                let mut xi = Tangent::zeros();
                xi.fixed_rows_mut::<3>(0).copy_from(&(axis * angle));
                xi.fixed_rows_mut::<3>(3).copy_from(&Vector3::new(1.0, -2.0, 0.7));
                let analytic = right_jacobian_inverse(&xi);
                for column in 0..6 {
                    let mut step = Tangent::zeros();
                    step[column] = 1e-5;
                    let plus = se3::log(&(se3::exp(&xi) * se3::exp(&step)));
                    let minus = se3::log(&(se3::exp(&xi) * se3::exp(&-step)));
                    assert_relative_eq!(
                        analytic.column(column).into_owned(),
                        (plus - minus) / 2e-5,
                        epsilon = 1e-7,
                        max_relative = 1e-6
                    );
                }
            }
        }
    }
}
