//! A prediction near a point: its derivatives to the latent and to the camera's pose.

use nalgebra::{DMatrix, DVector, Dyn, OMatrix, U6};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Pose, Viewpoint};

/// The model's prediction near a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// `h(e, x_rel)`, `[M]`.
    pub mean: DVector<f64>,
    /// `d h / d e`, `[M x D]`.
    pub d_latent: DMatrix<f64>,
    /// `d h / d x_rel`.
    pub d_viewpoint: ViewpointDerivative,
}

impl Linearization {
    /// Whether it has the shapes of M measured and D latent numbers and is finite throughout.
    pub fn is_valid(&self, measurement_dim: usize, latent_dim: usize) -> bool {
        self.mean.len() == measurement_dim
            && self.d_latent.shape() == (measurement_dim, latent_dim)
            && self.mean.iter().chain(&self.d_latent).all(|x| x.is_finite())
            && self.d_viewpoint.is_valid(measurement_dim)
    }
}

/// `d h / d x_rel`, by the numbers of [`Viewpoint::conditioning`] as if they were independent.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewpointDerivative(DMatrix<f64>);

impl ViewpointDerivative {
    /// The derivative by the viewpoint's coordinates, `[M x CONDITIONING]`.
    pub fn new(by_coordinates: DMatrix<f64>) -> Self {
        Self(by_coordinates)
    }

    /// The derivative by the azimuth, `[M]`, and by the upright numbers of [`Viewpoint::conditioning`], which follow its harmonics,
    /// `[M x CONDITIONING - 2 HARMONICS]`.
    pub fn by_azimuth_and_upright(
        viewpoint: &Viewpoint,
        by_azimuth: &DVector<f64>,
        by_upright: &DMatrix<f64>,
    ) -> Self {
        // d azimuth = cos d(sin) - sin d(cos), by the first two coordinates alone.
        let (sin, cos) = libm::sincos(viewpoint.azimuth());
        let mut by_coordinates = DMatrix::zeros(by_azimuth.len(), CONDITIONING);
        by_coordinates.set_column(0, &(by_azimuth * -sin));
        by_coordinates.set_column(1, &(by_azimuth * cos));
        by_coordinates.columns_mut(2 * HARMONICS, by_upright.ncols()).copy_from(by_upright);
        Self(by_coordinates)
    }

    /// The derivative by the upright numbers.
    pub fn by_upright(&self) -> DMatrix<f64> {
        self.0.columns(2 * HARMONICS, CONDITIONING - 2 * HARMONICS).into_owned()
    }

    /// Whether it has the shape of M measured numbers and is finite throughout.
    pub fn is_valid(&self, measurement_dim: usize) -> bool {
        self.0.shape() == (measurement_dim, CONDITIONING) && self.0.iter().all(|x| x.is_finite())
    }

    /// `[M x CONDITIONING]`.
    pub fn by_coordinates(&self) -> &DMatrix<f64> {
        &self.0
    }

    /// `left * d h / d xi`, `[n x 6]`, of the camera `object_from_camera * Exp(xi)` that sees an object of
    /// `object_size` metres; `left` is `[n x M]`. `None` where the viewpoint is undefined.
    pub fn by_camera(
        &self,
        left: &DMatrix<f64>,
        object_from_camera: &Pose,
        object_size: f64,
    ) -> Option<OMatrix<f64, Dyn, U6>> {
        Some(left * &self.0 * Viewpoint::jacobian(object_from_camera, object_size)?)
    }

    /// `d h / d azimuth`, `[M]`, per radian.
    pub fn by_azimuth(&self, viewpoint: &Viewpoint) -> DVector<f64> {
        &self.0 * harmonics_by_angle(&viewpoint.conditioning())
    }
}

/// The derivative by an angle of numbers that begin with its harmonics, `[cos m a, sin m a for m = 1..=5, ..]`, the rest constant.
pub fn harmonics_by_angle(x: &[f64]) -> DVector<f64> {
    let mut derivative = DVector::zeros(x.len());
    for m in 1..=HARMONICS {
        derivative[2 * m - 2] = -(m as f64) * x[2 * m - 1];
        derivative[2 * m - 1] = m as f64 * x[2 * m - 2];
    }
    derivative
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use vantage_dataset::{Tangent, se3};

    #[test]
    fn the_derivative_by_azimuth_is_that_of_a_turn() {
        let direction = Vector3::new(0.5, -0.7, 0.4).normalize();
        let viewpoint = Viewpoint { direction, roll: 0.1, log_distance: 0.7 };
        let (step, x) = (1e-6, viewpoint.conditioning());
        let (ahead, behind) = (viewpoint.turned(step).conditioning(), viewpoint.turned(-step).conditioning());
        let derivative = harmonics_by_angle(&x);
        for i in 0..CONDITIONING {
            let measured = (ahead[i] - behind[i]) / (2.0 * step);
            assert!((derivative[i] - measured).abs() < 1e-8, "{i}: {} {measured}", derivative[i]);
        }
    }

    #[test]
    fn the_derivative_by_the_camera_is_that_of_a_step_and_none_at_the_object() {
        let weights = DMatrix::from_fn(3, CONDITIONING, |i, j| (i as f64 + 1.3 * j as f64).sin());
        let left = DMatrix::from_fn(2, 3, |i, j| 1.0 + i as f64 - 0.5 * j as f64);
        let derivative = ViewpointDerivative::new(weights.clone());
        let eye = Vector3::new(1.0, -0.6, 0.5);
        let pose = Pose::face_towards(&eye.into(), &nalgebra::Point3::origin(), &-Vector3::z());
        let at = |pose: &Pose| {
            let x = Viewpoint::new(pose, 0.4).unwrap().conditioning();
            &left * &weights * DVector::from_column_slice(&x)
        };
        let analytic = derivative.by_camera(&left, &pose, 0.4).unwrap();
        for column in 0..6 {
            let step = |size: f64| Tangent::from_fn(|i, _| if i == column { size } else { 0.0 });
            let (ahead, behind) = (at(&(pose * se3::exp(&step(1e-6)))), at(&(pose * se3::exp(&step(-1e-6)))));
            let difference = (ahead - behind) / 2e-6 - analytic.column(column);
            assert!(difference.amax() < 1e-7, "column {column}: {difference}");
        }
        assert_eq!(derivative.by_camera(&left, &Pose::identity(), 0.4), None);
    }
}
