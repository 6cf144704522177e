//! Cumulative distribution functions of the laws that intervals and calibration are checked against.

/// `P(X <= x)` of the chi-square law with `degrees > 0` degrees of freedom.
pub fn chi_squared_cdf(x: f64, degrees: f64) -> f64 {
    incomplete_gamma(degrees / 2.0, x / 2.0)
}

/// The `x` with `P(X <= x) = probability`, between 0 and 1, of the chi-square law with `degrees > 0` degrees of freedom.
pub fn chi_squared_quantile(probability: f64, degrees: f64) -> f64 {
    let mut high = degrees;
    while chi_squared_cdf(high, degrees) < probability {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..80 {
        let middle = (low + high) / 2.0;
        if chi_squared_cdf(middle, degrees) < probability { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

/// `P(X <= x)` of Fisher's F law with `numerator` and `denominator` degrees of freedom, both positive.
///
/// The squared whitened norm of a d-variate Student t of `v` degrees of freedom, over d, follows it with (d, v).
pub fn fisher_f_cdf(x: f64, numerator: f64, denominator: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    incomplete_beta(numerator / 2.0, denominator / 2.0, 1.0 / (1.0 + denominator / (numerator * x)))
}

/// `P(|X| <= x)` of Student's t law with `degrees > 0` degrees of freedom, `x >= 0`.
pub fn student_t_within(x: f64, degrees: f64) -> f64 {
    fisher_f_cdf(x * x, 1.0, degrees)
}

/// `P(X <= x)` of the standard normal law.
pub fn normal_cdf(x: f64) -> f64 {
    libm::erfc(-x / std::f64::consts::SQRT_2) / 2.0
}

/// The `x` with `P(X <= x) = probability`, between 0 and 1, of the standard normal law.
pub fn normal_quantile(probability: f64) -> f64 {
    let (mut low, mut high) = (-40.0, 40.0);
    for _ in 0..80 {
        let middle = (low + high) / 2.0;
        if normal_cdf(middle) < probability { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

/// The regularized incomplete beta function `I_x(a, b)`, `0 <= x <= 1`.
pub(crate) fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let log_front =
        libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log1p(-x);
    let front = libm::exp(log_front);
    if x < (a + 1.0) / (a + b + 2.0) {
        front * beta_fraction(a, b, x) / a
    } else {
        1.0 - front * beta_fraction(b, a, 1.0 - x) / b
    }
}

/// The continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), by Lentz's method.
fn beta_fraction(a: f64, b: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let keep = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / keep(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for step in 1..=300 {
        let m = f64::from(step);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / keep(1.0 + even * d);
        c = keep(1.0 + even / c);
        fraction *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / keep(1.0 + odd * d);
        c = keep(1.0 + odd / c);
        fraction *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    fraction
}

/// The regularized lower incomplete gamma function `P(a, x)`, by its series (Abramowitz and Stegun 6.5.29).
fn incomplete_gamma(a: f64, x: f64) -> f64 {
    /// What is left above is less than the precision of the result (Chernoff's bound).
    const NEGLIGIBLE: f64 = -45.0;
    if x <= 0.0 {
        return 0.0;
    }
    if x > a && a - x + a * libm::log(x / a) < NEGLIGIBLE {
        return 1.0;
    }
    let (mut term, mut sum, mut divisor) = (1.0 / a, 1.0 / a, a);
    while term > sum * f64::EPSILON / 2.0 {
        divisor += 1.0;
        term *= x / divisor;
        sum += term;
    }
    (sum * libm::exp(a * libm::log(x) - x - libm::lgamma(a))).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    /// Values of scipy.stats 1.17.
    #[test]
    fn values_are_those_of_scipy() {
        for (x, degrees, expected) in [
            (0.1, 1.0, 0.24817036595415076),
            (3.84, 1.0, 0.9499564787512949),
            (31.0, 32.0, 0.4829887527302919),
            (46.19, 32.0, 0.9499569069311672),
            (80.0, 32.0, 0.9999945360192887),
            (1.0, 64.0, 5.449400304668091e-46),
        ] {
            assert_relative_eq!(chi_squared_cdf(x, degrees), expected, max_relative = 1e-11);
        }
        for (x, numerator, denominator, expected) in [
            (0.3, 1.0, 4.5, 0.3900699601248622),
            (1.0, 32.0, 13.678, 0.47547929605535216),
            (2.5, 32.0, 13.678, 0.9628451457099723),
            (0.05, 64.0, 200.0, 1.5412489972087204e-28),
            (9.0, 2.0, 1.0, 0.7705842661294382),
        ] {
            assert_relative_eq!(fisher_f_cdf(x, numerator, denominator), expected, max_relative = 1e-11);
        }
        for (x, degrees, expected) in [
            (0.5, 3.0, 0.34855203515184896),
            (2.15, 13.678, 0.9500431796823846),
            (12.7, 1.0, 0.9499756723106558),
        ] {
            assert_relative_eq!(student_t_within(x, degrees), expected, max_relative = 1e-11);
        }
    }

    #[test]
    fn the_ends_are_0_and_1() {
        assert_eq!((chi_squared_cdf(0.0, 3.0), chi_squared_cdf(1e6, 3.0)), (0.0, 1.0));
        assert_eq!((fisher_f_cdf(0.0, 3.0, 4.0), fisher_f_cdf(f64::INFINITY, 3.0, 4.0)), (0.0, 1.0));
    }

    #[test]
    fn the_normal_law_and_its_quantiles_are_those_of_the_tables() {
        for (x, expected) in [(-3.0, 0.0013498980316300933), (0.0, 0.5), (1.96, 0.9750021048517795)] {
            assert_relative_eq!(normal_cdf(x), expected, max_relative = 1e-14);
        }
        for (probability, expected) in
            [(0.975, 1.959963984540054), (0.8, 0.8416212335729143), (0.0001, -3.7190164854556804)]
        {
            assert_relative_eq!(normal_quantile(probability), expected, max_relative = 1e-13);
        }
        assert!(normal_quantile(0.5).abs() < 1e-15);
    }

    #[test]
    fn chi_squared_quantiles_are_those_of_the_tables_and_invert() {
        for (probability, degrees, expected) in [
            (0.025, 6.0, 1.237_344_246),
            (0.95, 1.0, 3.841_458_821),
            (0.95, 3.0, 7.814_727_903),
            (0.975, 6.0, 14.449_375_335),
        ] {
            assert_relative_eq!(chi_squared_quantile(probability, degrees), expected, max_relative = 1e-9);
        }
        let many = 6.0 * 1000.0;
        assert_relative_eq!(chi_squared_cdf(chi_squared_quantile(0.025, many), many), 0.025, epsilon = 1e-9);
    }

    #[test]
    fn the_norm_of_a_student_t_follows_the_f_law() {
        let (mut stream, n, d, v) = (Seed(2).stream("t", 0), 4000, 5, 6);
        let mut below = 0;
        for _ in 0..n {
            let norm: f64 = (0..d).map(|_| stream.normal().powi(2)).sum();
            let chi: f64 = (0..v).map(|_| stream.normal().powi(2)).sum();
            let squared = norm / (chi / f64::from(v));
            below += u32::from(fisher_f_cdf(squared / f64::from(d), f64::from(d), f64::from(v)) <= 0.8);
        }
        assert!((f64::from(below) / f64::from(n) - 0.8).abs() < 0.02, "{below} of {n}");
    }
}
