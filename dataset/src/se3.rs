//! SE(3): exponential, logarithm and adjoint, rotation before translation.

use nalgebra::{Isometry3, Matrix3, Matrix6, Quaternion, Translation3, UnitQuaternion, Vector3, Vector6};

/// A rigid transform; `a_from_b` maps coordinates in frame `b` to frame `a`.
pub type Pose = Isometry3<f64>;

/// A tangent vector of SE(3): `[omega; v]`, radians then metres.
pub type Tangent = Vector6<f64>;

const SMALL_ANGLE_SQUARED: f64 = 1e-8;

/// The skew-symmetric matrix with `hat(a) * b == a.cross(&b)`.
pub fn hat(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Whether all numbers of a pose are finite.
pub fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|number| number.is_finite())
}

/// The exponential of SO(3).
pub fn so3_exp(omega: &Vector3<f64>) -> UnitQuaternion<f64> {
    let theta_squared = omega.norm_squared();
    let (real, scale) = if theta_squared < SMALL_ANGLE_SQUARED {
        (1.0 - theta_squared / 8.0, 0.5 - theta_squared / 48.0)
    } else {
        let theta = theta_squared.sqrt();
        (libm::cos(theta / 2.0), libm::sin(theta / 2.0) / theta)
    };
    UnitQuaternion::new_normalize(Quaternion::from_parts(real, omega * scale))
}

/// The logarithm of SO(3), of norm at most pi.
pub fn so3_log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    let (w, v) = if q.w < 0.0 { (-q.w, -q.imag()) } else { (q.w, q.imag()) };
    let norm = v.norm();
    if norm * norm < SMALL_ANGLE_SQUARED {
        return v * (2.0 / w - 2.0 * norm * norm / (3.0 * w * w * w));
    }
    v * (2.0 * libm::atan2(norm, w) / norm)
}

/// The left Jacobian of SO(3), which is also `V` in `Exp([omega; v]).translation = V v`.
pub fn so3_left_jacobian(omega: &Vector3<f64>) -> Matrix3<f64> {
    let theta_squared = omega.norm_squared();
    let w = hat(omega);
    let (a, b) = if theta_squared < SMALL_ANGLE_SQUARED {
        (0.5 - theta_squared / 24.0, 1.0 / 6.0 - theta_squared / 120.0)
    } else {
        let theta = theta_squared.sqrt();
        ((1.0 - libm::cos(theta)) / theta_squared, (theta - libm::sin(theta)) / (theta_squared * theta))
    };
    Matrix3::identity() + w * a + w * w * b
}

/// The inverse of [`so3_left_jacobian`].
pub fn so3_left_jacobian_inverse(omega: &Vector3<f64>) -> Matrix3<f64> {
    let theta_squared = omega.norm_squared();
    let w = hat(omega);
    let b = if theta_squared < SMALL_ANGLE_SQUARED {
        1.0 / 12.0 + theta_squared / 720.0
    } else {
        let theta = theta_squared.sqrt();
        1.0 / theta_squared - libm::cos(theta / 2.0) / (2.0 * theta * libm::sin(theta / 2.0))
    };
    Matrix3::identity() - w * 0.5 + w * w * b
}

/// The full exponential of SE(3).
pub fn exp(xi: &Tangent) -> Pose {
    let omega = xi.fixed_rows::<3>(0).into_owned();
    let v = xi.fixed_rows::<3>(3).into_owned();
    Pose::from_parts(Translation3::from(so3_left_jacobian(&omega) * v), so3_exp(&omega))
}

/// The logarithm of SE(3).
pub fn log(pose: &Pose) -> Tangent {
    let omega = so3_log(&pose.rotation);
    let v = so3_left_jacobian_inverse(&omega) * pose.translation.vector;
    let mut xi = Tangent::zeros();
    xi.fixed_rows_mut::<3>(0).copy_from(&omega);
    xi.fixed_rows_mut::<3>(3).copy_from(&v);
    xi
}

/// The adjoint: `T Exp(xi) T^-1 = Exp(adjoint(T) xi)`.
pub fn adjoint(pose: &Pose) -> Matrix6<f64> {
    let r = pose.rotation.to_rotation_matrix().into_inner();
    let mut ad = Matrix6::zeros();
    ad.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 0).copy_from(&(hat(&pose.translation.vector) * r));
    ad
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn tangents() -> Vec<Tangent> {
        let mut all = vec![Tangent::zeros()];
        for scale in [1e-12, 1e-5, 1e-4, 0.3, 1.0, PI - 1e-4] {
            for axis in [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, -0.8)] {
                let mut xi = Tangent::zeros();
                xi.fixed_rows_mut::<3>(0).copy_from(&(axis * scale));
                xi.fixed_rows_mut::<3>(3).copy_from(&Vector3::new(1.0, -20.0, 0.3));
                all.push(xi);
            }
        }
        all
    }

    #[test]
    fn one_stray_number_makes_a_pose_infinite() {
        assert!(is_finite(&Pose::identity()));
        for stray in [f64::NAN, f64::INFINITY] {
            let mut pose = Pose::identity();
            pose.rotation.as_mut_unchecked().coords.y = stray;
            assert!(!is_finite(&pose));
            assert!(!is_finite(&Pose::translation(0.0, stray, 0.0)));
        }
    }

    #[test]
    fn log_inverts_exp() {
        for xi in tangents() {
            assert_relative_eq!(log(&exp(&xi)), xi, epsilon = 1e-9, max_relative = 1e-9);
        }
    }

    #[test]
    fn exp_inverts_log_for_any_rotation() {
        for angle in [3.5, -3.5, 2.0 * PI - 1e-6, PI, 30.0] {
            let pose = Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.0, 0.6, 0.8) * angle);
            let negated = Pose::from_parts(
                pose.translation,
                UnitQuaternion::new_unchecked(-pose.rotation.into_inner()),
            );
            for p in [pose, negated] {
                assert!(log(&p).fixed_rows::<3>(0).norm() <= PI + 1e-12);
                assert_relative_eq!(exp(&log(&p)).to_homogeneous(), p.to_homogeneous(), epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn exp_is_a_one_parameter_group() {
        for xi in tangents() {
            let whole = exp(&xi);
            let halves = exp(&(xi * 0.5)) * exp(&(xi * 0.5));
            assert_relative_eq!(whole.to_homogeneous(), halves.to_homogeneous(), epsilon = 1e-8);
        }
    }

    #[test]
    fn adjoint_moves_a_perturbation_to_the_left() {
        let pose = Pose::new(Vector3::new(0.3, -2.0, 1.0), Vector3::new(0.5, 0.2, -1.1));
        for xi in tangents() {
            let right = pose * exp(&xi);
            let left = exp(&(adjoint(&pose) * xi)) * pose;
            assert_relative_eq!(right.to_homogeneous(), left.to_homogeneous(), epsilon = 1e-8);
        }
    }

    #[test]
    fn jacobian_and_inverse_agree() {
        for xi in tangents() {
            let omega = xi.fixed_rows::<3>(0).into_owned();
            let product = so3_left_jacobian(&omega) * so3_left_jacobian_inverse(&omega);
            assert_relative_eq!(product, Matrix3::identity(), epsilon = 1e-9);
        }
    }
}
