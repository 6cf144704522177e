//! The multivariate Student t of `nu` degrees of freedom over M numbers, by the squared norm `s = |W r|^2` of the
//! whitened residual.

use std::f64::consts::PI;

/// `(nu + M)/2 log(1 + s/nu)`: the negative log-density, nats, but for what does not depend on `s`.
pub fn loss(s: f64, dimension: usize, nu: f64) -> f64 {
    (nu + dimension as f64) / 2.0 * libm::log1p(s / nu)
}

/// `(nu + M)/(nu + s)`: twice the derivative of [`loss`], the weight of iteratively reweighted least squares.
pub fn weight(s: f64, dimension: usize, nu: f64) -> f64 {
    (nu + dimension as f64) / (nu + s)
}

/// `log p(0)`, nats, of unit scale; that of a Gaussian where `nu` is infinite.
pub fn log_normalizer(dimension: usize, nu: f64) -> f64 {
    let d = dimension as f64;
    if nu.is_finite() {
        libm::lgamma((nu + d) / 2.0) - libm::lgamma(nu / 2.0) - 0.5 * d * libm::log(nu * PI)
    } else {
        -d / 2.0 * libm::log(2.0 * PI)
    }
}

/// `log p(r)`, nats, with `log_det` the logarithm of the determinant of `W`; `nu` is finite.
pub fn log_density(s: f64, dimension: usize, nu: f64, log_det: f64) -> f64 {
    log_normalizer(dimension, nu) + log_det - loss(s, dimension, nu)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_density_of_one_number_integrates_to_one() {
        let (r, step) = (3.0f64, 1e-3);
        let integral: f64 = (-40_000..=40_000)
            .map(|i| {
                let whitened = r * f64::from(i) * step;
                log_density(whitened * whitened, 1, 4.0, r.ln()).exp() * step
            })
            .sum();
        assert_relative_eq!(integral, 1.0, epsilon = 1e-5);
    }

    #[test]
    fn with_many_degrees_of_freedom_it_is_the_gaussian() {
        let gaussian = -0.5 * (3.0 * (2.0 * PI).ln() + 2.5);
        assert_relative_eq!(log_density(2.5, 3, 1e9, 0.0), gaussian, epsilon = 1e-6);
        assert_relative_eq!(log_normalizer(3, f64::INFINITY) - 1.25, gaussian, epsilon = 1e-12);
    }
}
