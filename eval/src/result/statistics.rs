//! Means with 95% intervals over seeds.

use crate::result::distribution::incomplete_beta;
use serde::{Deserialize, Serialize};

/// A mean over seeds with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mean {
    /// Number of values.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Half the width of the 95% interval, by Student's t; `None` for one value.
    pub half_width: Option<f64>,
    /// Their sample standard deviation; `None` for one value.
    pub deviation: Option<f64>,
}

impl Mean {
    /// Of finite values, `None` for none. The sum runs in the order given: sort where order may vary.
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        if n == 0 {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n as f64;
        let deviation = (n > 1).then(|| {
            let squares = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
            (squares / (n - 1) as f64).sqrt()
        });
        let half_width = deviation.map(|d| student_t_975(n - 1) * d / (n as f64).sqrt());
        Some(Self { n, mean, half_width, deviation })
    }

    /// Lower and upper bound of the interval; `None` for one value.
    pub fn interval(&self) -> Option<(f64, f64)> {
        self.half_width.map(|h| (self.mean - h, self.mean + h))
    }
}

/// The `q` quantile of sorted values, linear between them; `None` for none.
pub fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let position = q * last as f64;
    let below = (position.floor() as usize).min(last);
    let above = (below + 1).min(last);
    Some(sorted[below] + (sorted[above] - sorted[below]) * (position - below as f64))
}

/// The 0.975 quantile of Student's t: two-sided 95%.
pub fn student_t_975(degrees_of_freedom: usize) -> f64 {
    let (mut low, mut high) = (1.9, 13.0);
    for _ in 0..80 {
        let middle = (low + high) / 2.0;
        if upper_tail(middle, degrees_of_freedom as f64) > 0.025 { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

/// `P(T > t)` for `t > 0`: half the regularized incomplete beta function `I_x(v/2, 1/2)`, `x = v / (v + t^2)`.
fn upper_tail(t: f64, v: f64) -> f64 {
    incomplete_beta(v / 2.0, 0.5, v / (v + t * t)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    #[test]
    fn t_quantiles_are_those_of_the_tables() {
        let table = [
            (1, 12.706_204_736),
            (2, 4.302_652_730),
            (3, 3.182_446_305),
            (5, 2.570_581_836),
            (9, 2.262_157_163),
            (19, 2.093_024_054),
            (30, 2.042_272_456),
            (100, 1.983_971_519),
            (1000, 1.962_339_081),
        ];
        for (degrees, expected) in table {
            assert_relative_eq!(student_t_975(degrees), expected, epsilon = 1e-8);
        }
    }

    #[test]
    fn mean_and_interval_of_known_values() {
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!((mean.n, mean.mean), (4, 2.5));
        assert_relative_eq!(mean.deviation.unwrap(), (5.0f64 / 3.0).sqrt(), epsilon = 1e-12);
        assert_relative_eq!(
            mean.half_width.unwrap(),
            3.182_446_305 * (5.0f64 / 3.0).sqrt() / 2.0,
            epsilon = 1e-8
        );
        assert_eq!(Mean::of(&[7.0]).unwrap().interval(), None);
        assert_eq!(Mean::of(&[]), None);
        assert_eq!(Mean::of(&[2.0; 5]).unwrap().interval(), Some((2.0, 2.0)));
    }

    #[test]
    fn intervals_cover_the_truth_as_often_as_they_say() {
        let mut stream = Seed(4).stream("coverage", 0);
        let covered = (0..4000)
            .filter(|_| {
                let values: Vec<f64> = (0..6).map(|_| 3.0 + 2.0 * stream.normal()).collect();
                let (low, high) = Mean::of(&values).unwrap().interval().unwrap();
                low <= 3.0 && 3.0 <= high
            })
            .count();
        assert!((covered as f64 / 4000.0 - 0.95).abs() < 0.012, "{covered} of 4000");
    }

    #[test]
    fn quantiles_interpolate() {
        let sorted = [1.0, 2.0, 4.0];
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| quantile(&sorted, q).unwrap()),
            [1.0, 1.5, 2.0, 3.0, 4.0]
        );
        assert_eq!(quantile(&[], 0.5), None);
    }
}
