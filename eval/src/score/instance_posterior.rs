//! `P(beta | z)` of Eq. 14 at test time: which of the known instances a measurement is of.

use super::retrieval::{are_comparable, squared_distance};

/// How well the posterior over known instances picks the right one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstancePosterior {
    /// Share of embeddings whose most likely instance is the right one, alone.
    pub accuracy: f64,
    /// Mean probability of the right one.
    pub probability: f64,
}

/// The posterior `P(beta | e) ~ N(e; mu_beta, sigma^2 I)` under a uniform prior over the instances, at the embedding of
/// each measurement.
///
/// `instances[i]` indexes `means`. Several instances equally likely are no answer, so that an encoder that maps all to
/// one point is never right.
///
/// `None` for no embedding, a `sigma` that is not positive and finite, an instance without a mean, or vectors that are
/// not finite and of one length.
///
/// # Panics
/// If there is not one instance an embedding.
pub fn instance_posterior(
    embeddings: &[Vec<f32>],
    instances: &[usize],
    means: &[Vec<f32>],
    sigma: f64,
) -> Option<InstancePosterior> {
    assert_eq!(embeddings.len(), instances.len(), "each embedding needs its instance");
    let comparable = are_comparable(embeddings)
        && are_comparable(means)
        && embeddings.first().map(Vec::len) == means.first().map(Vec::len);
    let named = instances.iter().all(|&instance| instance < means.len());
    let spread = sigma > 0.0 && sigma.is_finite();
    if embeddings.is_empty() || !comparable || !named || !spread {
        return None;
    }
    let (mut right, mut probability) = (0usize, 0.0);
    for (embedding, &instance) in embeddings.iter().zip(instances) {
        let squared: Vec<f64> = means.iter().map(|mean| squared_distance(embedding, mean)).collect();
        let own = squared[instance];
        let rivals = squared.iter().enumerate().filter(|&(other, _)| other != instance);
        right += usize::from(rivals.clone().all(|(_, &other)| own < other));
        // 1 / sum of exp(log p_other - log p_own), each other's share of the own one.
        let odds: f64 = rivals.map(|(_, other)| libm::exp((own - other) / (2.0 * sigma * sigma))).sum();
        probability += 1.0 / (1.0 + odds);
    }
    let n = embeddings.len() as f64;
    Some(InstancePosterior { accuracy: right as f64 / n, probability: probability / n })
}

/// Means of known instances, and their common standard deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownInstances {
    /// `mu_beta`, of the instances `0..`.
    pub means: Vec<Vec<f32>>,
    /// `s`: of one number about its instance's mean, over all numbers and instances.
    pub sigma: f64,
}

impl KnownInstances {
    /// Of the instances `0..count`, from embeddings of each.
    ///
    /// `None` where an instance has no embedding, no instance has two, or the embeddings are not finite and of one length.
    pub fn fit(embeddings: &[Vec<f32>], instances: &[usize], count: usize) -> Option<Self> {
        let length = embeddings.first()?.len();
        if !are_comparable(embeddings) {
            return None;
        }
        let mut sums = vec![vec![0.0f64; length]; count];
        let mut sizes = vec![0usize; count];
        for (embedding, &instance) in embeddings.iter().zip(instances) {
            *sizes.get_mut(instance)? += 1;
            sums[instance].iter_mut().zip(embedding).for_each(|(sum, x)| *sum += f64::from(*x));
        }
        if sizes.contains(&0) {
            return None;
        }
        let mean = |(sum, &size): (&Vec<f64>, &usize)| sum.iter().map(|s| (s / size as f64) as f32).collect();
        let means: Vec<Vec<f32>> = sums.iter().zip(&sizes).map(mean).collect();
        let squares: f64 = embeddings
            .iter()
            .zip(instances)
            .map(|(e, &instance)| squared_distance(e, &means[instance]))
            .sum();
        let freedom = (embeddings.len() - count) * length;
        (freedom > 0).then(|| Self { means, sigma: (squares / freedom as f64).sqrt() })
    }

    /// `P(beta | e)` of each instance, under a uniform prior.
    pub fn posterior(&self, embedding: &[f32]) -> Vec<f64> {
        let logs: Vec<f64> = self
            .means
            .iter()
            .map(|mean| -squared_distance(embedding, mean) / (2.0 * self.sigma * self.sigma))
            .collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares: Vec<f64> = logs.iter().map(|log| libm::exp(log - most)).collect();
        let sum: f64 = shares.iter().sum();
        shares.into_iter().map(|share| share / sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    #[test]
    fn the_posterior_of_each_instance_sums_to_one_and_agrees_with_the_score() {
        let known = KnownInstances { means: vec![vec![0.0], vec![2.0], vec![7.0]], sigma: 0.5 };
        let posterior = known.posterior(&[0.9]);
        assert_relative_eq!(posterior.iter().sum::<f64>(), 1.0, epsilon = 1e-12);
        let scored = instance_posterior(&[vec![0.9]], &[0], &known.means, known.sigma).unwrap();
        assert_relative_eq!(posterior[0], scored.probability, epsilon = 1e-9);
        assert!(known.posterior(&[1e4]).iter().all(|share| share.is_finite()));
    }

    #[test]
    fn the_posterior_of_two_known_instances_is_a_logistic() {
        let means = [vec![0.0], vec![2.0]];
        let at = |x: f32| instance_posterior(&[vec![x]], &[0], &means, 0.5).unwrap();
        // log odds = ((x - 2)^2 - x^2) / (2 * 0.25) = 8 - 8 x
        assert_relative_eq!(at(0.75).probability, 1.0 / (1.0 + (-2.0f64).exp()), epsilon = 1e-12);
        assert_eq!((at(0.75).accuracy, at(1.25).accuracy), (1.0, 0.0));
        assert_eq!(at(1.0), InstancePosterior { accuracy: 0.0, probability: 0.5 });
        assert_eq!(at(-1e6).probability, 1.0);
        assert_eq!(at(1e6).probability, 0.0);
    }

    #[test]
    fn truth_is_perfect_and_random_embeddings_are_at_chance() {
        let means: Vec<Vec<f32>> = (0..20).map(|i| vec![1e3 * i as f32, 0.0]).collect();
        let instances: Vec<usize> = (0..20).collect();
        let perfect = instance_posterior(&means, &instances, &means, 1.0).unwrap();
        assert_eq!(perfect, InstancePosterior { accuracy: 1.0, probability: 1.0 });
        let mut stream = Seed(1).stream("noise", 0);
        let mut draw = || vec![stream.normal() as f32, stream.normal() as f32];
        let means: Vec<Vec<f32>> = (0..20).map(|_| draw()).collect();
        let noise: Vec<Vec<f32>> = (0..4000).map(|_| draw()).collect();
        let labels: Vec<usize> = (0..4000).map(|i| i % 20).collect();
        let random = instance_posterior(&noise, &labels, &means, 1.0).unwrap();
        assert!((random.accuracy - 0.05).abs() < 0.015, "{random:?}");
        assert!((random.probability - 0.05).abs() < 0.015, "{random:?}");
    }

    #[test]
    fn a_right_sigma_gives_probabilities_that_are_frequencies() {
        let mut stream = Seed(2).stream("draws", 0);
        let means: Vec<Vec<f32>> = (0..8).map(|i| vec![i as f32 * 2.0, 0.0, 0.0]).collect();
        let instances: Vec<usize> = (0..8000).map(|i| i % 8).collect();
        let draws: Vec<Vec<f32>> = instances
            .iter()
            .map(|&i| means[i].iter().map(|m| m + stream.normal() as f32).collect())
            .collect();
        let known = KnownInstances::fit(&draws, &instances, 8).unwrap();
        assert_relative_eq!(known.sigma, 1.0, epsilon = 0.02);
        // Where probabilities are frequencies, the right one's mean is that of the sum of all squared.
        let wide = instance_posterior(&draws, &instances, &means, 1.0).unwrap();
        let squares: f64 = draws
            .iter()
            .map(|e| {
                let p: Vec<f64> = means.iter().map(|m| (-0.5 * squared_distance(e, m)).exp()).collect();
                p.iter().map(|x| x * x).sum::<f64>() / p.iter().sum::<f64>().powi(2)
            })
            .sum::<f64>()
            / 8000.0;
        assert_relative_eq!(wide.probability, squares, epsilon = 0.01);
    }

    #[test]
    fn the_order_of_instances_changes_nothing_but_rounding() {
        let mut stream = Seed(3).stream("noise", 0);
        let mut draw = || vec![stream.normal() as f32, stream.normal() as f32];
        let (means, noise): (Vec<_>, Vec<_>) = (0..9).map(|_| (draw(), draw())).unzip();
        let instances: Vec<usize> = (0..9).collect();
        let reversed: Vec<Vec<f32>> = means.iter().rev().cloned().collect();
        let moved: Vec<usize> = instances.iter().map(|i| 8 - i).collect();
        let here = instance_posterior(&noise, &instances, &means, 0.7).unwrap();
        let there = instance_posterior(&noise, &moved, &reversed, 0.7).unwrap();
        assert_eq!(here.accuracy, there.accuracy);
        assert_relative_eq!(here.probability, there.probability, epsilon = 1e-12);
    }

    #[test]
    fn undefined_is_none() {
        let one = [vec![1.0f32]];
        for (embeddings, instances, means, sigma) in [
            (&one[..], &[0usize][..], &one[..], 0.0),
            (&one[..], &[1][..], &one[..], 1.0),
            (&one[..], &[0][..], &[vec![1.0, 2.0]][..], 1.0),
            (&[vec![f32::NAN]][..], &[0][..], &one[..], 1.0),
            (&[][..], &[][..], &one[..], 1.0),
        ] {
            assert_eq!(instance_posterior(embeddings, instances, means, sigma), None);
        }
        assert_eq!(KnownInstances::fit(&one, &[0], 2), None);
        assert_eq!(KnownInstances::fit(&one, &[0], 1), None);
    }
}
