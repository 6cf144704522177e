//! The periodic squared-exponential kernel over the azimuth, by its Fourier features.

/// Highest harmonic of the azimuth.
pub const HARMONICS: usize = 6;
/// A constant, and cosine and sine of each harmonic.
pub const FEATURES: usize = 2 * HARMONICS + 1;

/// `phi(azimuth)`, with `phi(a)^T phi(a') = exp(kappa (cos(a - a') - 1))` but for the harmonics beyond the last, whose share the
/// others take so that `phi^T phi = 1`.
pub fn features(kappa: f64, azimuth: f64) -> [f64; FEATURES] {
    let spectrum = spectrum(kappa);
    let mut phi = [0.0; FEATURES];
    phi[0] = spectrum[0].sqrt();
    for m in 1..=HARMONICS {
        let (sin, cos) = libm::sincos(m as f64 * azimuth);
        let amplitude = spectrum[m].sqrt();
        phi[2 * m - 1] = amplitude * cos;
        phi[2 * m] = amplitude * sin;
    }
    phi
}

/// `d phi / d azimuth` of features `phi`.
pub fn derivative(phi: &[f64; FEATURES]) -> [f64; FEATURES] {
    let mut derivative = [0.0; FEATURES];
    for m in 1..=HARMONICS {
        derivative[2 * m - 1] = -(m as f64) * phi[2 * m];
        derivative[2 * m] = m as f64 * phi[2 * m - 1];
    }
    derivative
}

/// `I_0, 2 I_1, .. 2 I_H` of kappa over their sum: the share of each harmonic in the kernel's variance.
fn spectrum(kappa: f64) -> [f64; HARMONICS + 1] {
    let mut spectrum = std::array::from_fn(|m| if m == 0 { 1.0 } else { 2.0 } * bessel(m, kappa));
    let sum: f64 = spectrum.iter().sum();
    spectrum.iter_mut().for_each(|share| *share /= sum);
    spectrum
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
        for (kappa, tolerance) in [(0.5, 1e-6), (2.0, 2e-3)] {
            for step in 0..12 {
                let (a, b) = (0.3, 0.3 + 0.5 * f64::from(step));
                let product: f64 =
                    features(kappa, a).iter().zip(features(kappa, b)).map(|(x, y)| x * y).sum();
                let kernel = libm::exp(kappa * (libm::cos(a - b) - 1.0));
                assert!((product - kernel).abs() < tolerance, "{kappa}, {step}: {product} {kernel}");
            }
        }
    }

    #[test]
    fn bessel_functions_are_those_of_tables() {
        assert!((bessel(0, 1.0) - 1.266_065_877_752_008_4).abs() < 1e-14);
        assert!((bessel(2, 3.0) - 2.245_212_440_929_951).abs() < 1e-13);
    }
}
