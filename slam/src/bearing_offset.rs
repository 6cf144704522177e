//! How the centre of an object's box lies off the object's centre: a smooth function of the azimuth it is seen from.
//!
//! In units of the box's angular size, either coordinate of the offset is a Gaussian process over the azimuth `a` with the periodic kernel
//! `sigma^2 exp((cos(a - a') - 1) / length^2)`. Its Fourier series, cut where next to nothing is left and scaled to `sigma^2` at `a = a'`, makes
//! it `sigma phi(a)^T c` with `c` standard normal, and
//!
//! ```text
//! phi(a) = [w_0, w_1 cos a, w_1 sin a, w_2 cos 2a, w_2 sin 2a, ...],   w_0^2 : w_h^2 = I_0(1 / length^2) : 2 I_h(1 / length^2)
//! ```
//!
//! with `I_h` the modified Bessel functions of the first kind.

use garde::Validate;
use nalgebra::DVector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// Share of the kernel that the series may leave out.
const LEFT_OUT: f64 = 1e-3;
/// Below this share of its sum a term of a Bessel function's series is rounding.
const ROUNDING: f64 = 1e-17;

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
    /// Length scale of the kernel: about the turn, radians, over which the offset changes. Many harmonics are needed where
    /// it is small.
    #[garde(range(min = 0.2, max = 100.0), custom(not_nan))]
    pub length: f64,
}

impl BearingOffset {
    /// The features of the azimuth.
    pub fn harmonics(&self) -> Harmonics {
        let argument = 1.0 / (self.length * self.length);
        let whole = libm::exp(argument);
        let mut weights = vec![bessel(0, argument)];
        let mut sum = weights[0];
        while whole - sum > LEFT_OUT * whole {
            let weight = 2.0 * bessel(weights.len(), argument);
            sum += weight;
            weights.push(weight);
        }
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

/// `I_h(z)` by its power series, all of whose terms are positive.
fn bessel(harmonic: usize, z: f64) -> f64 {
    let half = z / 2.0;
    let mut term: f64 = (1..=harmonic).map(|k| half / k as f64).product();
    let mut sum = 0.0;
    let mut k = 0;
    while term > ROUNDING * sum {
        sum += term;
        k += 1;
        term *= half * half / (k * (k + harmonic)) as f64;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn direction(azimuth: f64) -> [f64; 2] {
        [libm::cos(azimuth), libm::sin(azimuth)]
    }

    #[test]
    fn bessel_functions_are_as_tabulated() {
        for (harmonic, z, value) in [
            (0, 1.0, 1.266_065_877_752_008),
            (1, 1.0, 0.565_159_103_992_485),
            (3, 2.0, 0.212_739_959_239_853),
            (0, 25.0, 5_774_560_606.466_7),
        ] {
            assert_relative_eq!(bessel(harmonic, z), value, max_relative = 1e-12);
        }
        assert_eq!((bessel(0, 0.0), bessel(2, 0.0)), (1.0, 0.0));
    }

    #[test]
    fn features_span_the_periodic_kernel() {
        for length in [0.2, 0.5, 1.0, 3.0, 100.0] {
            let harmonics = BearingOffset { horizontal: 0.0, vertical: 0.0, length }.harmonics();
            let of = |azimuth| harmonics.at(direction(azimuth)).0;
            for (a, b) in [(0.3, 0.3), (0.3, 0.5), (-2.0, 3.0), (6.0, 0.1)] {
                let kernel = libm::exp((libm::cos(a - b) - 1.0) / (length * length));
                assert_relative_eq!(of(a).dot(&of(b)), kernel, epsilon = 3e-3);
                assert_relative_eq!(of(a).norm(), 1.0, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_features() {
        let harmonics = BearingOffset { horizontal: 0.0, vertical: 0.0, length: 0.5 }.harmonics();
        for azimuth in [-3.0, -1.0, 0.0, 0.4, 2.5] {
            let (_, derivative) = harmonics.at(direction(azimuth));
            let of = |azimuth| harmonics.at(direction(azimuth)).0;
            let numeric = (of(azimuth + 1e-6) - of(azimuth - 1e-6)) / 2e-6;
            assert_relative_eq!(derivative, numeric, epsilon = 1e-8);
        }
    }
}
