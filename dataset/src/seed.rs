//! Random streams: one per noise source, so that changing one never reshuffles another.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// The seed of an episode, a training run or a world. Required everywhere; 0 is a seed like any other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Seed(pub u64);

impl Seed {
    /// The stream of numbers named `name`, for item `index` (an instance, a step, ...).
    ///
    /// The key is a hash of (seed, name, index): work can be split over threads without changing a result.
    pub fn stream(self, name: &str, index: u64) -> Stream {
        Stream(ChaCha8Rng::from_seed(self.key(name, index)))
    }

    /// A seed of its own for a part of the work.
    pub fn child(self, name: &str, index: u64) -> Seed {
        let key = self.key(name, index);
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&key[..8]);
        Seed(u64::from_le_bytes(bytes))
    }

    fn key(self, name: &str, index: u64) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.0.to_le_bytes());
        hasher.update(&index.to_le_bytes());
        hasher.update(name.as_bytes());
        *hasher.finalize().as_bytes()
    }
}

/// A reproducible stream of random numbers, the same on every platform.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// Uniform on `[0, 1)` with 53 random bits.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform on `[low, high)`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Standard normal (Box-Muller, in `libm` so that every platform draws the same).
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(2.0 * std::f64::consts::PI * self.unit())
    }

    /// Uniform on `0..n`.
    ///
    /// # Panics
    /// If `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        assert!(n > 0, "cannot draw from an empty range");
        ((u128::from(self.0.next_u64()) * n as u128) >> 64) as usize
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// A random permutation of the slice (Fisher-Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_key_same_draws_and_any_other_key_differs() {
        let draws = |seed: u64, name: &str, index: u64| {
            let mut stream = Seed(seed).stream(name, index);
            [stream.unit(), stream.unit()]
        };
        assert_eq!(draws(0, "odometry", 0), draws(0, "odometry", 0));
        assert_ne!(draws(0, "odometry", 0), draws(1, "odometry", 0));
        assert_ne!(draws(0, "odometry", 0), draws(0, "lighting", 0));
        assert_ne!(draws(0, "odometry", 0), draws(0, "odometry", 1));
    }

    #[test]
    fn the_stream_is_pinned() {
        let mut stream = Seed(7).stream("pin", 3);
        let bits: Vec<u64> = (0..3).map(|_| stream.unit().to_bits()).collect();
        assert_eq!(bits, PINNED);
    }

    const PINNED: [u64; 3] = [4601825315895102548, 4599199570347476136, 4600317512582872404];

    #[test]
    fn normal_has_zero_mean_and_unit_variance() {
        let mut stream = Seed(1).stream("normal", 0);
        let draws: Vec<f64> = (0..20_000).map(|_| stream.normal()).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "mean {mean}, variance {variance}");
    }
}
