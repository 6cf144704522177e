//! Terms of the evidence lower bound (Eq. 12, 20) on views that were not trained on, nats.

use vantage_learn::LatentGaussian;

/// That part of [`student_t_log_density`] which depends on the residual.
pub fn student_t_log_kernel(squared: f64, d: usize, nu: f64) -> f64 {
    -0.5 * (nu + d as f64) * libm::log1p(squared / nu)
}

/// `log p(r)` of a Student t with `nu` degrees of freedom, location 0 and scale matrix `(R^T R)^-1`, `R` of size `d`.
///
/// `squared` is `|R r|^2`, and `log_det` is `log |R|`.
pub fn student_t_log_density(squared: f64, d: usize, nu: f64, log_det: f64) -> f64 {
    let kernel = student_t_log_kernel(squared, d, nu);
    let d = d as f64;
    libm::lgamma((nu + d) / 2.0) - libm::lgamma(nu / 2.0) - 0.5 * d * libm::log(nu * std::f64::consts::PI)
        + log_det
        + kernel
}

/// `KL(q || N(0, I))`.
pub fn divergence(q: &LatentGaussian) -> f64 {
    let numbers = q.mean.iter().zip(q.variance.iter());
    numbers.map(|(mean, variance)| 0.5 * (mean * mean + variance - libm::log(*variance) - 1.0)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::DVector;

    #[test]
    fn the_density_of_one_number_integrates_to_one() {
        let (r, step) = (3.0f64, 1e-3);
        let integral: f64 = (-40_000..=40_000)
            .map(|i| {
                let whitened = r * f64::from(i) * step;
                student_t_log_density(whitened * whitened, 1, 4.0, r.ln()).exp() * step
            })
            .sum();
        assert_relative_eq!(integral, 1.0, epsilon = 1e-5);
    }

    #[test]
    fn with_many_degrees_of_freedom_it_is_the_gaussian() {
        let gaussian = -0.5 * (3.0 * (2.0 * std::f64::consts::PI).ln() + 2.5);
        assert_relative_eq!(student_t_log_density(2.5, 3, 1e9, 0.0), gaussian, epsilon = 1e-6);
    }

    #[test]
    fn the_prior_does_not_diverge_from_itself_and_certainty_costs() {
        let gaussian = |mean: f64, variance: f64| LatentGaussian {
            mean: DVector::from_element(2, mean),
            variance: DVector::from_element(2, variance),
        };
        assert_relative_eq!(divergence(&gaussian(0.0, 1.0)), 0.0);
        assert_relative_eq!(divergence(&gaussian(1.0, 1.0)), 1.0);
        assert_relative_eq!(divergence(&gaussian(0.0, 0.5)), 0.5 - 1.0 + 2f64.ln());
    }
}
