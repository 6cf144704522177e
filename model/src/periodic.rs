//! Smooth periodic random functions: a Gaussian process over the circle, by the Fourier features of its kernel.
//!
//! ```text
//! f(a) = phi(a)^T b,   b ~ N(0, I),   E f(a) f(a') = exp(kappa (cos(a - a') - 1))
//! ```
//!
//! The kernel is the periodic one of Rasmussen and Williams, Eq. 4.31: near 0 a Gaussian of length `1 / sqrt(kappa)` radians.

/// Highest harmonic.
pub const HARMONICS: usize = 6;
/// Length of `phi`: a constant, and cosine and sine of each harmonic.
pub const FEATURES: usize = 2 * HARMONICS + 1;

/// Smooth functions of an angle, of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    amplitudes: [f64; HARMONICS + 1],
}

impl Periodic {
    /// Those of concentration `kappa`, which is not negative. What the harmonics beyond the last would have of the variance, the others
    /// take: `phi(a)^T phi(a) = 1`.
    pub fn new(kappa: f64) -> Self {
        // I_0, 2 I_1, .. 2 I_H of kappa.
        let spectrum: [f64; HARMONICS + 1] =
            std::array::from_fn(|m| if m == 0 { 1.0 } else { 2.0 } * bessel(m, kappa));
        let sum: f64 = spectrum.iter().sum();
        Self { amplitudes: spectrum.map(|share| (share / sum).sqrt()) }
    }

    /// `phi` at an angle, radians.
    pub fn features(&self, angle: f64) -> [f64; FEATURES] {
        let mut phi = [0.0; FEATURES];
        phi[0] = self.amplitudes[0];
        for m in 1..=HARMONICS {
            let (sin, cos) = libm::sincos(m as f64 * angle);
            phi[2 * m - 1] = self.amplitudes[m] * cos;
            phi[2 * m] = self.amplitudes[m] * sin;
        }
        phi
    }
}

/// `d phi / d angle` of features `phi`.
pub fn derivative(phi: &[f64; FEATURES]) -> [f64; FEATURES] {
    let mut derivative = [0.0; FEATURES];
    for m in 1..=HARMONICS {
        derivative[2 * m - 1] = -(m as f64) * phi[2 * m];
        derivative[2 * m] = m as f64 * phi[2 * m - 1];
    }
    derivative
}

/// `I_m(x)`, the modified Bessel function of the first kind, by its series.
fn bessel(m: usize, x: f64) -> f64 {
    let half = x / 2.0;
    let mut term = (1..=m).map(|k| half / k as f64).product::<f64>();
    let (mut sum, mut n) = (term, 0.0);
    while term > 1e-16 * sum {
        n += 1.0;
        term *= half * half / (n * (n + m as f64));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_features_sum_to_the_kernel() {
        for (kappa, tolerance) in [(0.0, 1e-12), (0.5, 1e-6), (2.0, 2e-3)] {
            let functions = Periodic::new(kappa);
            for step in 0..12 {
                let (a, b) = (0.3, 0.3 + 0.5 * f64::from(step));
                let product: f64 =
                    functions.features(a).iter().zip(functions.features(b)).map(|(x, y)| x * y).sum();
                let kernel = libm::exp(kappa * (libm::cos(a - b) - 1.0));
                assert!((product - kernel).abs() < tolerance, "{kappa}, {step}: {product} {kernel}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let functions = Periodic::new(3.0);
        let slope = derivative(&functions.features(0.7));
        let (after, before) = (functions.features(0.7 + 1e-6), functions.features(0.7 - 1e-6));
        for (i, exact) in slope.iter().enumerate() {
            assert!(((after[i] - before[i]) / 2e-6 - exact).abs() < 1e-8, "{i}");
        }
    }

    #[test]
    fn bessel_functions_are_those_of_tables() {
        assert!((bessel(0, 1.0) - 1.266_065_877_752_008_4).abs() < 1e-14);
        assert!((bessel(2, 3.0) - 2.245_212_440_929_951).abs() < 1e-13);
    }
}
