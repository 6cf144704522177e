//! The plane: poses `(x, y, heading)` as [`Key::Robot`](crate::Key) and points `(x, y)` as [`Key::Landmark`](crate::Key), both vectors.
//!
//! Headings are not wrapped: a sum is a motion, and a difference is wrapped where it is a residual.

mod between;
mod motion;
mod point;
mod prior;
mod range_bearing;
mod sensor;
mod slam;

pub use between::PlanarBetween;
pub use motion::Motion;
pub use point::PlanarPoint;
pub use prior::PlanarPrior;
pub use range_bearing::RangeBearing;
pub use sensor::{CLUTTER, Detection, Sensing, Sensor};
pub use slam::{MotionMeasurement, PlanarNoise, PlanarSlam, PointMeasurement, landmark, pose};

use crate::factor::LinearFactor;
use crate::variable::{Key, Values};
use nalgebra::{Const, DMatrix, DVector, DimMin, Matrix2, Matrix2x3, SMatrix, SVector, Vector2, Vector3};
use std::f64::consts::PI;

/// A square root of the information of independent numbers, from their deviations.
pub fn whitening<const N: usize>(deviations: [f64; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_diagonal(&SVector::from(deviations).map(|deviation| 1.0 / deviation))
}

/// `log` of what `exp(-|W r|^2 / 2)` is multiplied with to be a density of `r`.
pub fn log_normalizer<const N: usize>(whitening: &SMatrix<f64, N, N>) -> f64
where
    Const<N>: DimMin<Const<N>, Output = Const<N>>,
{
    libm::log(whitening.determinant().abs()) - N as f64 / 2.0 * libm::log(2.0 * PI)
}

/// An angle in `[-pi, pi]`.
pub fn wrapped(angle: f64) -> f64 {
    libm::remainder(angle, 2.0 * PI)
}

fn vector3(values: &Values, key: Key) -> Option<Vector3<f64>> {
    values.vector(key).filter(|v| v.len() == 3).map(|v| Vector3::from_column_slice(v.as_slice()))
}

fn vector2(values: &Values, key: Key) -> Option<Vector2<f64>> {
    values.vector(key).filter(|v| v.len() == 2).map(|v| Vector2::from_column_slice(v.as_slice()))
}

/// World to robot.
fn rotation(heading: f64) -> Matrix2<f64> {
    let (s, c) = (libm::sin(heading), libm::cos(heading));
    Matrix2::new(c, s, -s, c)
}

/// The derivative of [`rotation`] by the heading.
fn rotation_slope(heading: f64) -> Matrix2<f64> {
    let (s, c) = (libm::sin(heading), libm::cos(heading));
    Matrix2::new(-s, c, -c, -s)
}

/// A point in a robot's frame, and its derivative by the robot's pose.
fn seen(robot: &Vector3<f64>, point: &Vector2<f64>) -> (Vector2<f64>, Matrix2x3<f64>) {
    let offset = point - robot.xy();
    let turn = rotation(robot.z);
    let mut by_robot = Matrix2x3::zeros();
    by_robot.fixed_view_mut::<2, 2>(0, 0).copy_from(&-turn);
    by_robot.set_column(2, &(rotation_slope(robot.z) * offset));
    (turn * offset, by_robot)
}

fn linear<const N: usize>(residual: SVector<f64, N>, jacobians: Vec<DMatrix<f64>>) -> Option<LinearFactor> {
    let factor = LinearFactor { residual: DVector::from_column_slice(residual.as_slice()), jacobians };
    let finite = factor.residual.iter().all(|x| x.is_finite())
        && factor.jacobians.iter().all(|j| j.iter().all(|x| x.is_finite()));
    finite.then_some(factor)
}

fn dynamic<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> DMatrix<f64> {
    DMatrix::from_column_slice(R, C, matrix.as_slice())
}
