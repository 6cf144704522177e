//! Calibration: whether the residuals of unseen instances are as large as the model's noise says.

use crate::result::distribution::{chi_squared_cdf, fisher_f_cdf, student_t_within};
use nalgebra::DVector;

/// Probabilities of the regions that are looked at.
pub const REGIONS: [f64; 3] = [0.5, 0.8, 0.95];

/// Residuals against the law that the model claims for them.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Residuals.
    pub residuals: usize,
    /// Share inside the ellipsoids that should hold each of [`REGIONS`], by the Student t: `|r|^2 / d ~ F(d, v)`.
    pub inside: [f64; 3],
    /// The same by the Gaussian of the same covariance: `|r|^2 (v - 2) / v ~ chi^2(d)`; `None` for `v <= 2`, which has
    /// no covariance.
    pub gaussian_inside: Option<[f64; 3]>,
    /// Of each whitened number, the shares inside the intervals that should hold [`REGIONS`]; `[d]`.
    pub number_inside: Vec<[f64; 3]>,
    /// Of each residual the probability of the ellipsoid by the Student t on whose surface it is, ascending.
    pub probabilities: Vec<f64>,
    /// The same by the Gaussian of the same covariance.
    pub gaussian_probabilities: Option<Vec<f64>>,
    /// Variance of `|r|^2` over that of the law, 1 for residuals as claimed; `None` for `v <= 4`, where the law has
    /// none.
    pub squared_norm_variance: Option<f64>,
}

/// Holds whitened residuals `r = R (m - m(e, x))`, all of one length `d`, against a d-variate Student t of unit scale with
/// `v` degrees of freedom (infinity for a Gaussian).
///
/// `None` for no residual, or residuals that are not finite and of one length.
pub fn calibration(whitened: &[DVector<f64>], degrees_of_freedom: f64) -> Option<Calibration> {
    let d = whitened.first()?.len();
    if d == 0 || whitened.iter().any(|r| r.len() != d || r.iter().any(|x| !x.is_finite())) {
        return None;
    }
    let (n, numbers, v) = (whitened.len() as f64, d as f64, degrees_of_freedom);
    let gaussian = v.is_infinite();
    let squared: Vec<f64> = whitened.iter().map(DVector::norm_squared).collect();
    let shares = |probabilities: &[f64]| {
        REGIONS.map(|region| probabilities.partition_point(|&p| p <= region) as f64 / n)
    };
    let ascending = |probability: &dyn Fn(f64) -> f64| {
        let mut found: Vec<f64> = squared.iter().map(|&s| probability(s)).collect();
        found.sort_by(f64::total_cmp);
        found
    };
    let within = |x: f64| {
        if gaussian { chi_squared_cdf(x * x, 1.0) } else { student_t_within(x.abs(), v) }
    };
    let of_number = |i: usize| {
        let mut found: Vec<f64> = whitened.iter().map(|r| within(r[i])).collect();
        found.sort_by(f64::total_cmp);
        shares(&found)
    };
    let shrink = if gaussian { 1.0 } else { (v - 2.0) / v };
    let mean = squared.iter().sum::<f64>() / n;
    let variance = squared.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n;
    let claimed = if gaussian {
        2.0 * numbers
    } else {
        2.0 * v * v * numbers * (numbers + v - 2.0) / ((v - 2.0).powi(2) * (v - 4.0))
    };
    let probabilities = if gaussian {
        ascending(&|s| chi_squared_cdf(s, numbers))
    } else {
        ascending(&|s| fisher_f_cdf(s / numbers, numbers, v))
    };
    let gaussian_probabilities = (v > 2.0).then(|| ascending(&|s| chi_squared_cdf(s * shrink, numbers)));
    Some(Calibration {
        residuals: whitened.len(),
        inside: shares(&probabilities),
        gaussian_inside: gaussian_probabilities.as_deref().map(shares),
        number_inside: (0..d).map(of_number).collect(),
        probabilities,
        gaussian_probabilities,
        squared_norm_variance: (v > 4.0).then(|| variance / claimed),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    /// Draws of a t of unit scale (a Gaussian for no degrees), times `scale`.
    fn draws(n: usize, d: usize, degrees: usize, scale: f64) -> Vec<DVector<f64>> {
        let mut stream = Seed(7).stream("t", degrees as u64);
        (0..n)
            .map(|_| {
                let normal = DVector::from_fn(d, |_, _| stream.normal());
                let chi: f64 = (0..degrees).map(|_| stream.normal().powi(2)).sum();
                let tail = if degrees == 0 { 1.0 } else { (chi / degrees as f64).sqrt() };
                normal * (scale / tail)
            })
            .collect()
    }

    fn close(found: [f64; 3], expected: [f64; 3]) -> bool {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02)
    }

    #[test]
    fn residuals_of_the_law_fill_its_regions() {
        let found = calibration(&draws(6000, 8, 30, 1.0), 30.0).unwrap();
        assert!(close(found.inside, REGIONS), "{found:?}");
        assert!(found.number_inside.len() == 8);
        assert!(
            found
                .number_inside
                .iter()
                .all(|&shares| close(shares, REGIONS) && (shares[2] - 0.95).abs() < 0.012),
            "{found:?}"
        );
        assert!((found.squared_norm_variance.unwrap() - 1.0).abs() < 0.15, "{found:?}");
        let gaussian = calibration(&draws(6000, 8, 0, 1.0), f64::INFINITY).unwrap();
        assert!(close(gaussian.inside, REGIONS) && gaussian.gaussian_inside == Some(gaussian.inside));
        assert!((gaussian.squared_norm_variance.unwrap() - 1.0).abs() < 0.1, "{gaussian:?}");
    }

    #[test]
    fn too_large_residuals_and_heavy_tails_are_seen() {
        let large = calibration(&draws(3000, 8, 12, 1.5), 12.0).unwrap();
        assert!(large.inside[2] < 0.75 && large.number_inside[0][2] < 0.9, "{large:?}");
        // Heavy tails of the right covariance: more in the middle, too few inside the Gaussian's 95%.
        let heavy = calibration(&draws(6000, 8, 5, 1.0), 5.0).unwrap();
        let as_gaussian = heavy.gaussian_inside.unwrap();
        assert!(close(heavy.inside, REGIONS), "{heavy:?}");
        assert!(as_gaussian[0] > 0.65 && as_gaussian[2] < 0.93, "{heavy:?}");
    }

    #[test]
    fn order_changes_no_share_and_laws_without_moments_have_none() {
        let mut residuals = draws(200, 3, 3, 1.0);
        let here = calibration(&residuals, 3.0).unwrap();
        residuals.reverse();
        assert_eq!(calibration(&residuals, 3.0).unwrap(), here);
        assert_eq!(here.squared_norm_variance, None);
        assert!(here.gaussian_inside.is_some());
        assert_eq!(calibration(&residuals, 1.5).unwrap().gaussian_inside, None);
        assert_eq!(calibration(&[], 3.0), None);
        assert_eq!(calibration(&[DVector::from_element(2, f64::NAN)], 3.0), None);
        assert_eq!(calibration(&[DVector::zeros(2), DVector::zeros(3)], 3.0), None);
    }
}
