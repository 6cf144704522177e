//! How the centre of an object's box lies off the object's centre: a smooth function of the azimuth it is seen from.
//!
//! In units of the box's angular size, either coordinate of the offset is a Gaussian process over the azimuth `a` with a circular Matern kernel
//! (Guinness and Fuentes 2016). It is a cosine series, cut and scaled to `sigma^2` at `a = a'`, so that the process is
//! `sigma phi(a)^T c` with `c` standard normal, and
//!
//! ```text
//! phi(a) = [w_0, w_1 cos a, w_1 sin a, w_2 cos 2a, w_2 sin 2a, ...]
//! w_0^2 : w_h^2 = g(0) : 2 g(h),   g(h) = (1 / length^2 + h^2)^(-smoothness - 1/2)
//! ```

use garde::Validate;
use nalgebra::DVector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// Harmonics at most. What changes faster is white.
const MOST_HARMONICS: usize = 16;
/// Share of the kernel that fewer harmonics may leave out.
const LEFT_OUT: f64 = 1e-3;

/// The prior of the offset of a box's centre, box sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct BearingOffset {
    /// Standard deviation along the image's horizontal, box sides.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub horizontal: f64,
    /// Standard deviation along the image's vertical, box sides.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub vertical: f64,
    /// Length scale of the kernel, radians: over a longer turn than this little is shared.
    #[garde(range(min = 0.05, max = 100.0), custom(not_nan))]
    pub length: f64,
    /// Smoothness of the kernel: 1/2 where the offset has kinks at every azimuth, the larger, the smoother.
    #[garde(range(min = 0.1, max = 20.0), custom(not_nan))]
    pub smoothness: f64,
}

impl BearingOffset {
    /// The features of the azimuth.
    pub fn harmonics(&self) -> Harmonics {
        let least = 1.0 / (self.length * self.length);
        let weight = |harmonic: usize| {
            let squared = (harmonic * harmonic) as f64;
            // Over that of the constant.
            let ratio = libm::pow((least + squared) / least, -self.smoothness - 0.5);
            if harmonic == 0 { ratio } else { 2.0 * ratio }
        };
        let mut weights: Vec<f64> = (0..=MOST_HARMONICS).map(weight).collect();
        let mut left_out = 0.0;
        let most = LEFT_OUT * weights.iter().sum::<f64>();
        while let Some(&last) = weights.last().filter(|&&last| left_out + last <= most) {
            left_out += last;
            weights.pop();
        }
        let sum: f64 = weights.iter().sum();
        Harmonics { amplitudes: weights.into_iter().map(|weight| (weight / sum).sqrt()).collect() }
    }
}

/// `phi(a)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    /// `w_h`, by harmonic.
    amplitudes: Vec<f64>,
}

impl Harmonics {
    /// Numbers of `phi`.
    pub fn count(&self) -> usize {
        2 * self.amplitudes.len() - 1
    }

    /// `phi(a)` and its derivative, of the azimuth with this cosine and sine.
    pub fn at(&self, [cosine, sine]: [f64; 2]) -> (DVector<f64>, DVector<f64>) {
        let mut phi = DVector::zeros(self.count());
        let mut derivative = DVector::zeros(self.count());
        let (mut c, mut s) = (1.0, 0.0);
        for (harmonic, &amplitude) in self.amplitudes.iter().enumerate() {
            if harmonic == 0 {
                phi[0] = amplitude;
                continue;
            }
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
            let (of_cosine, slope) = (2 * harmonic - 1, amplitude * harmonic as f64);
            phi[of_cosine] = amplitude * c;
            phi[of_cosine + 1] = amplitude * s;
            derivative[of_cosine] = -slope * s;
            derivative[of_cosine + 1] = slope * c;
        }
        (phi, derivative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn direction(azimuth: f64) -> [f64; 2] {
        [libm::cos(azimuth), libm::sin(azimuth)]
    }

    fn offset(length: f64, smoothness: f64) -> BearingOffset {
        BearingOffset { horizontal: 0.0, vertical: 0.0, length, smoothness }
    }

    #[test]
    fn features_span_the_kernel() {
        // The whole series of smoothness 1/2, in closed form.
        for length in [1.0, 3.0] {
            let exponential = |turn: f64| libm::cosh((PI - turn) / length) / libm::cosh(PI / length);
            let of = |azimuth| offset(length, 0.5).harmonics().at(direction(azimuth)).0;
            for turn in [0.0, 0.5, 1.5, 3.0] {
                assert_relative_eq!(of(0.4).dot(&of(0.4 + turn)), exponential(turn), epsilon = 0.04);
            }
        }
    }

    #[test]
    fn a_smooth_kernel_takes_few_harmonics_and_all_have_unit_variance() {
        let mut counts = Vec::new();
        for (length, smoothness) in [(100.0, 2.0), (1.0, 5.0), (0.5, 2.0), (0.05, 0.1)] {
            let harmonics = offset(length, smoothness).harmonics();
            for azimuth in [-3.0, 0.3, 2.0] {
                assert_relative_eq!(harmonics.at(direction(azimuth)).0.norm(), 1.0, epsilon = 1e-12);
            }
            counts.push(harmonics.count());
        }
        assert!(counts.is_sorted() && counts[0] == 1 && counts[3] == 2 * MOST_HARMONICS + 1, "{counts:?}");
    }

    #[test]
    fn derivatives_are_those_of_the_features() {
        let harmonics = offset(0.5, 1.5).harmonics();
        for azimuth in [-3.0, -1.0, 0.0, 0.4, 2.5] {
            let (_, derivative) = harmonics.at(direction(azimuth));
            let of = |azimuth| harmonics.at(direction(azimuth)).0;
            let numeric = (of(azimuth + 1e-6) - of(azimuth - 1e-6)) / 2e-6;
            assert_relative_eq!(derivative, numeric, epsilon = 1e-8);
        }
    }
}
