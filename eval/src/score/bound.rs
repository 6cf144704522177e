//! Terms of the evidence lower bound (Eq. 12, 20) on views that were not trained on, nats.

use vantage_model::LatentGaussian;

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
