//! The posterior of an azimuth under a uniform prior, degree by degree.

use std::f64::consts::PI;
use vantage_dataset::Symmetry;

/// Azimuths, one degree apart from `-pi` on.
const POINTS: usize = 360;
/// Those that are asked first.
const COARSE: usize = 5;
/// Coarse steps whose likelihood is this much below the best, nats, are not asked in between.
const NEGLIGIBLE: f64 = 25.0;

/// Log-likelihood of each degree.
pub struct AzimuthPosterior {
    log_likelihood: Vec<f64>,
}

impl AzimuthPosterior {
    /// `None` where the likelihood is undefined somewhere, or prefers no azimuth at all.
    pub fn new(mut log_likelihood: impl FnMut(f64) -> Option<f64>) -> Option<Self> {
        let coarse: Option<Vec<f64>> =
            (0..POINTS).step_by(COARSE).map(|point| log_likelihood(azimuth(point))).collect();
        let coarse = coarse?;
        let extreme = |choose: fn(f64, f64) -> f64, from: f64| coarse.iter().copied().fold(from, choose);
        let (worst, best) = (extreme(f64::min, f64::INFINITY), extreme(f64::max, f64::NEG_INFINITY));
        if best <= worst {
            return None;
        }
        let steps = coarse.len();
        let mut all = Vec::with_capacity(POINTS);
        for (step, &value) in coarse.iter().enumerate() {
            let next = coarse[(step + 1) % steps];
            all.push(value);
            for between in 1..COARSE {
                let asked = value.max(next) > best - NEGLIGIBLE;
                let share = between as f64 / COARSE as f64;
                all.push(if asked {
                    log_likelihood(azimuth(step * COARSE + between))?
                } else {
                    value + share * (next - value)
                });
            }
        }
        Some(Self { log_likelihood: all })
    }

    /// The most likely azimuth, radians.
    pub fn most_likely(&self) -> f64 {
        let best = (0..POINTS).max_by(|&a, &b| self.log_likelihood[a].total_cmp(&self.log_likelihood[b]));
        azimuth(best.unwrap_or(0))
    }

    /// Whether the smallest region that holds `share` of the probability holds an azimuth, radians, or one that looks the same.
    /// The likelihood counts by `scale`.
    pub fn holds(&self, truth: f64, symmetry: Symmetry, share: f64, scale: f64) -> bool {
        let probability = self.probability(scale);
        let least_improbable = alike(truth, symmetry).map(|point| probability[point]).fold(0.0, f64::max);
        let before: f64 = probability.iter().filter(|&&p| p > least_improbable).sum();
        before < share
    }

    /// Log of the probability of an azimuth's degree, and of those that look the same; the likelihood counts by `scale`.
    pub fn log_probability(&self, truth: f64, symmetry: Symmetry, scale: f64) -> f64 {
        let probability = self.probability(scale);
        libm::log(alike(truth, symmetry).map(|point| probability[point]).sum::<f64>().max(f64::MIN_POSITIVE))
    }

    fn probability(&self, scale: f64) -> Vec<f64> {
        let best = self.log_likelihood.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut probability: Vec<f64> =
            self.log_likelihood.iter().map(|value| libm::exp(scale * (value - best))).collect();
        let sum: f64 = probability.iter().sum();
        probability.iter_mut().for_each(|p| *p /= sum);
        probability
    }
}

/// The degrees of an azimuth and of those that look the same.
fn alike(azimuth: f64, symmetry: Symmetry) -> impl Iterator<Item = usize> {
    let order = match symmetry {
        Symmetry::None | Symmetry::Revolution => 1,
        Symmetry::Cyclic { order } => order.max(1),
    };
    (0..order).map(move |turn| point(azimuth + 2.0 * PI * f64::from(turn) / f64::from(order)))
}

fn azimuth(point: usize) -> f64 {
    2.0 * PI * point as f64 / POINTS as f64 - PI
}

fn point(azimuth: f64) -> usize {
    ((azimuth + PI) / (2.0 * PI) * POINTS as f64).round().rem_euclid(POINTS as f64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    #[test]
    fn the_peak_is_found_and_regions_hold_the_share_that_they_promise() {
        let mut stream = Seed(3).stream("azimuths", 0);
        let (sigma, trials) = (0.2, 2000);
        let mut inside = 0;
        for _ in 0..trials {
            let truth = stream.uniform(-PI, PI);
            let seen = truth + sigma * stream.normal();
            let posterior = AzimuthPosterior::new(|a| {
                let error = libm::atan2(libm::sin(a - seen), libm::cos(a - seen));
                Some(-0.5 * (error / sigma).powi(2))
            })
            .unwrap();
            let off = Symmetry::None.azimuth_distance(posterior.most_likely(), seen).unwrap();
            assert!(off < 0.6f64.to_radians(), "{off}");
            inside += usize::from(posterior.holds(truth, Symmetry::None, 0.95, 1.0));
        }
        let share = inside as f64 / trials as f64;
        assert!((share - 0.95).abs() < 0.015, "{share}");
    }

    #[test]
    fn an_azimuth_that_looks_the_same_is_held_too() {
        let posterior = AzimuthPosterior::new(|a| Some(50.0 * libm::cos(a - 1.0))).unwrap();
        let opposite = 1.0 - PI;
        assert!(posterior.holds(opposite, Symmetry::Cyclic { order: 2 }, 0.95, 1.0));
        assert!(!posterior.holds(opposite, Symmetry::None, 0.95, 1.0));
        assert!(posterior.holds(opposite, Symmetry::None, 0.95, 0.0));
        let told = |symmetry| posterior.log_probability(opposite, symmetry, 1.0);
        assert!(told(Symmetry::Cyclic { order: 2 }) > -5.0 && told(Symmetry::None) < -50.0);
    }

    #[test]
    fn a_flat_likelihood_and_an_undefined_one_have_no_posterior() {
        assert!(AzimuthPosterior::new(|_| Some(1.0)).is_none());
        assert!(AzimuthPosterior::new(|a| (a < 1.0).then_some(a)).is_none());
    }
}
