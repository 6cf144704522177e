//! The instance term: how likely a latent is for its instance (Eq. 14), or its instance for the latent (Eq. 13).
//!
//! Both are on the invariant part: what turns is unknown where a view does not see it, so that pulling single views
//! together there would teach the encoder to say nothing.

use crate::train::network::exponential::log_softmax;
use crate::train::network::rows::{rows_of, table};
use burn::tensor::{Device, Tensor};

/// Logarithm of the share that a row's own instance has where it is among the others.
const EXCLUDED: f32 = -1e4;

/// What each view says alone of the invariant part, `q(e | z)`: mean and variance, `[rows, invariant]`.
pub(crate) struct Alone {
    mean: Tensor<2>,
    variance: Tensor<2>,
}

impl Alone {
    /// The product of each view's factor and the prior.
    pub(crate) fn new(mean: Tensor<2>, precision: Tensor<2>) -> Self {
        let variance = (precision.clone() + 1.0).recip();
        Self { mean: mean * precision * variance.clone(), variance }
    }

    /// `-E_q log N(e; mu, s^2 I)` of Eq. 14 and 23, but for the constant: `[rows, 1]`.
    pub(crate) fn unlikelihood(&self, mu: Tensor<2>, sigma: f64) -> Tensor<2> {
        let squares = (self.mean.clone() - mu).square() + self.variance.clone();
        squares.sum_dim(1) * (0.5 / (sigma * sigma))
    }

    /// `-E_q log P(beta | e)` with `P(beta | e) ~ N(e; mu_beta, s^2 I)`, Eq. 13: `[rows, 1]`.
    ///
    /// With `E_q log sum <= log sum E_q` (Jensen) and `E_q N(e; mu, s^2) = N(mean; mu, s^2 + variance)` it would be a bound from above,
    /// were the sum one over all instances. A row's own is exact; the sample `others`, uniform and with repeats, stands for the
    /// rest, so that the logarithm of the sum is low on average.
    pub(crate) fn surprise(
        &self,
        means: &Tensor<2>,
        own: &[i64],
        others: &[i64],
        sigma: f64,
        device: &Device,
    ) -> Tensor<2> {
        let rest: Vec<usize> =
            own.iter().map(|own| others.iter().filter(|&other| other != own).count()).collect();
        let every_other = (means.dims()[0] - 1) as f32;
        let stands_for: Vec<f32> = own
            .iter()
            .zip(&rest)
            .flat_map(|(own, &rest)| {
                let share = if rest > 0 { (every_other / rest as f32).ln() } else { EXCLUDED };
                others.iter().map(move |other| if other == own { EXCLUDED } else { share })
            })
            .collect();

        let variance = self.variance.clone() / (sigma * sigma);
        let sharpness = (variance.clone() + 1.0).recip() / (sigma * sigma);
        let mu = rows_of(means, own, device);
        let squared = (self.mean.clone() - mu.clone()).square() * sharpness.clone();
        let own_share = squared.sum_dim(1) * -0.5;
        let mu_others = rows_of(means, others, device).transpose();
        let squares = (self.mean.clone().square() * sharpness.clone()).sum_dim(1)
            - (self.mean.clone() * sharpness.clone()).matmul(mu_others.clone()) * 2.0
            + sharpness.matmul(mu_others.square());
        let shares = squares * -0.5 + table(stands_for, own.len(), device);
        let normalised = log_softmax(Tensor::cat(vec![own_share.clone(), shares], 1)).narrow(1, 0, 1);
        let log_sum = own_share - normalised - (variance + 1.0).log().sum_dim(1) * 0.5;
        self.unlikelihood(mu, sigma) + log_sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::run::scalar;

    const MEANS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.5], [-2.0, 0.3], [0.4, -0.9]];

    fn surprise(precision: f32, own: i64, others: &[i64], sigma: f64) -> f64 {
        let device = Device::flex();
        let means = table(MEANS.concat(), 4, &device);
        // The mean of the product with the prior is then (0.5, 0.2).
        let factor = [0.5, 0.2].map(|x: f32| x * (precision + 1.0) / precision);
        let alone = Alone::new(table(factor.to_vec(), 1, &device), table(vec![precision; 2], 1, &device));
        scalar(&alone.surprise(&means, &[own], others, sigma, &device).reshape([1]))
    }

    fn log_posterior(own: usize, e: [f64; 2], sigma: f64) -> f64 {
        let log = |mu: [f32; 2]| {
            let squares: f64 = mu.iter().zip(e).map(|(&mu, e)| (f64::from(mu) - e).powi(2)).sum();
            -0.5 * squares / (sigma * sigma)
        };
        log(MEANS[own]) - MEANS.iter().map(|&mu| log(mu).exp()).sum::<f64>().ln()
    }

    #[test]
    fn where_the_latent_is_certain_it_is_the_log_posterior() {
        for (own, sigma) in [(0, 1.0), (1, 0.5), (3, 2.0)] {
            let others: Vec<i64> = (0..4).collect();
            let (got, expected) =
                (surprise(1e6, own, &others, sigma), -log_posterior(own as usize, [0.5, 0.2], sigma));
            assert!((got - expected).abs() < 1e-3, "{got} {expected}");
        }
    }

    #[test]
    fn a_sample_stands_for_all_others_and_the_own_instance_counts_once() {
        let all = surprise(1e6, 1, &[0, 2, 3], 0.7);
        assert!((surprise(1e6, 1, &[0, 0, 1, 2, 2, 3, 3, 1], 0.7) - all).abs() < 1e-4);
        let alone = surprise(1e6, 1, &[1, 1], 0.7);
        assert!(alone.abs() < 1e-4, "{alone}");
    }

    #[test]
    fn where_it_is_not_it_bounds_the_expected_one_from_above() {
        // Gauss-Hermite with three points: nodes 0 and +-sqrt(3), weights 2/3 and 1/6.
        let points = [(0.0, 2.0 / 3.0), (3f64.sqrt(), 1.0 / 6.0), (-(3f64.sqrt()), 1.0 / 6.0)];
        let deviation = 0.1f64.sqrt();
        let mut expected = 0.0;
        for (x, of_x) in points {
            for (y, of_y) in points {
                expected -= of_x * of_y * log_posterior(1, [0.5 + deviation * x, 0.2 + deviation * y], 1.0);
            }
        }
        let bound = surprise(9.0, 1, &[0, 2, 3], 1.0);
        assert!(bound > expected && bound < expected + 0.1, "{bound} {expected}");
    }
}
