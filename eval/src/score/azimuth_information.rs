//! How well a model says that it knows the azimuth: the Fisher information of its likelihood at the true viewpoint.

use nalgebra::{DMatrix, DVector};

/// The standard deviation, radians, that the likelihood promises of an azimuth: `1 / sqrt(J^T S^-1 J)`, the bound of
/// Cramer and Rao, everything else known.
///
/// `derivative`, `[d]`, is that of the predicted measurement by the azimuth (per radian); `sqrt_information` is `R`,
/// `[d, d]`, with `S^-1 = R^T R`; `degrees_of_freedom`, `v`, that of the Student t, whose information is
/// `(v + d) / (v + d + 2)` of the Gaussian's of the same scale.
///
/// `None` where the prediction does not change with the azimuth, or is not finite.
pub fn promised_deviation(
    derivative: &DVector<f64>,
    sqrt_information: &DMatrix<f64>,
    degrees_of_freedom: f64,
) -> Option<f64> {
    let d = derivative.len() as f64;
    let gaussian = (sqrt_information * derivative).norm_squared();
    let information = gaussian * (degrees_of_freedom + d) / (degrees_of_freedom + d + 2.0);
    (information > 0.0 && information.is_finite()).then(|| 1.0 / information.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    #[test]
    fn a_known_gaussian_promises_its_deviation() {
        // m = (3 a, 4 a), each number with a deviation of 0.1: sigma = 0.1 / 5.
        let derivative = DVector::from_vec(vec![3.0, 4.0]);
        let sqrt_information = DMatrix::identity(2, 2) * 10.0;
        let promised = promised_deviation(&derivative, &sqrt_information, 1e12).unwrap();
        assert_relative_eq!(promised, 0.02, epsilon = 1e-9);
    }

    #[test]
    fn the_promise_is_kept_by_the_best_azimuth_under_the_models_own_noise() {
        let (d, v) = (6, 5);
        let derivative = DVector::from_fn(d, |i, _| 1.0 + i as f64);
        let promised = promised_deviation(&derivative, &DMatrix::identity(d, d), f64::from(v)).unwrap();
        let mut stream = Seed(4).stream("t", 0);
        let n = 3000;
        let squares: f64 = (0..n)
            .map(|_| {
                let chi: f64 = (0..v).map(|_| stream.normal().powi(2)).sum();
                let noise = DVector::from_fn(d, |_, _| stream.normal()) / (chi / f64::from(v)).sqrt();
                // The likelihood rises with falling |noise - J a|: least squares, whatever the tails.
                (derivative.dot(&noise) / derivative.norm_squared()).powi(2)
            })
            .sum();
        let found = (squares / f64::from(n)).sqrt();
        // Cramer and Rao: no less than promised; with one t draw for all numbers, not much more.
        assert!(found > 0.97 * promised && found < 1.6 * promised, "{found} against {promised}");
    }

    #[test]
    fn what_does_not_change_promises_nothing() {
        assert_eq!(promised_deviation(&DVector::zeros(3), &DMatrix::identity(3, 3), 5.0), None);
        let broken = DVector::from_element(3, f64::NAN);
        assert_eq!(promised_deviation(&broken, &DMatrix::identity(3, 3), 5.0), None);
    }
}
