//! The signed-rank test of Wilcoxon (1945): whether paired differences lie about zero.

use super::distribution::normal_cdf;

/// Most differences whose distribution is counted out: 2^50 signs are exact in an `f64`.
const EXACT: usize = 50;

/// Two-sided p-value of differences, in any order; `None` where none is other than zero.
///
/// Zeros are dropped; equal sizes share the mean of their ranks. Up to 50 differences all signs are counted, given the ranks. Of more
/// the law is taken for normal, with the variance of the ties and a correction for continuity.
pub fn wilcoxon(differences: &[f64]) -> Option<f64> {
    let mut nonzero: Vec<f64> = differences.iter().copied().filter(|difference| *difference != 0.0).collect();
    if nonzero.is_empty() {
        return None;
    }
    nonzero.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let ranked = Ranked::of(&nonzero);
    Some(if nonzero.len() <= EXACT { ranked.exact() } else { ranked.normal() })
}

/// Ranks of sizes, doubled so that means of ranks are whole.
struct Ranked {
    doubled: Vec<usize>,
    /// The sum of those of positive differences.
    positive: usize,
    /// Sum of `t^3 - t` over groups of `t` equal sizes.
    ties: f64,
}

impl Ranked {
    fn of(by_size: &[f64]) -> Self {
        let (mut doubled, mut positive, mut ties) = (Vec::with_capacity(by_size.len()), 0, 0.0);
        for group in by_size.chunk_by(|a, b| a.abs() == b.abs()) {
            // ranks first + 1 to first + n have the mean first + (n + 1) / 2
            let (first, n) = (doubled.len(), group.len());
            let rank = 2 * first + n + 1;
            doubled.extend(std::iter::repeat_n(rank, n));
            positive += rank * group.iter().filter(|difference| **difference > 0.0).count();
            ties += (n as f64).powi(3) - n as f64;
        }
        Self { doubled, positive, ties }
    }

    /// By how many of all signs give a sum as far out.
    fn exact(&self) -> f64 {
        let total: usize = self.doubled.iter().sum();
        let mut ways = vec![0.0f64; total + 1];
        ways[0] = 1.0;
        for &rank in &self.doubled {
            for sum in (rank..=total).rev() {
                ways[sum] += ways[sum - rank];
            }
        }
        // the law is symmetric about total / 2
        let outer = self.positive.min(total - self.positive);
        let tail: f64 = ways[..=outer].iter().sum();
        (2.0 * tail / ways.iter().sum::<f64>()).min(1.0)
    }

    fn normal(&self) -> f64 {
        let n = self.doubled.len() as f64;
        let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - self.ties / 48.0;
        let off = (self.positive as f64 / 2.0 - n * (n + 1.0) / 4.0).abs();
        2.0 * normal_cdf(-(off - 0.5).max(0.0) / variance.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    /// Sizes with every third negative, beginning with the first.
    fn signed(sizes: impl Iterator<Item = u32>) -> Vec<f64> {
        sizes.enumerate().map(|(i, size)| f64::from(size) * if i % 3 == 0 { -1.0 } else { 1.0 }).collect()
    }

    #[test]
    fn p_values_are_the_published_ones() {
        // Darwin's heights of cross- and self-fertilized maize, in eighths of an inch
        let maize =
            [6., 8., 14., 16., 23., 24., 28., 29., 41., -48., 49., 56., 60., -67., 75.].map(|d: f64| d / 8.0);
        assert_eq!(wilcoxon(&maize), Some(0.041259765625));
        for (n, p) in [(1, 1.0), (4, 0.125), (5, 0.0625), (6, 0.03125), (50, 1.7763568394002505e-15)] {
            let differences: Vec<f64> = (1..=n).map(|d| -f64::from(d)).collect();
            assert_eq!(wilcoxon(&differences), Some(p), "{n} of {n}");
        }
    }

    /// Expected values are those of `scipy.stats.wilcoxon`, by permutation of ties and by its corrected normal law.
    #[test]
    fn ties_zeros_and_many_differences_are_those_of_scipy() {
        let tied = [1., 1., -1., 2., 2., 3., -2., 4., 5., 5., -6.];
        assert_eq!(wilcoxon(&tied), Some(0.19140625));
        assert_eq!(wilcoxon(&[0., 0., 1., 2., -3., 4., 5., 6., 7.5]), Some(0.078125));
        let fifty: Vec<f64> = signed(0..51)[1..].to_vec();
        assert_relative_eq!(wilcoxon(&fifty).unwrap(), 0.02616696817119646, max_relative = 1e-12);
        let one_more: Vec<f64> = signed(0..52)[1..].to_vec();
        assert_relative_eq!(wilcoxon(&one_more).unwrap(), 0.05645580536770219, max_relative = 1e-12);
        let many = signed((0..60).map(|i| i / 4 + 1));
        assert_relative_eq!(wilcoxon(&many).unwrap(), 0.016845860091575262, max_relative = 1e-12);
    }

    #[test]
    fn without_a_difference_there_is_no_p_value_and_balance_is_1() {
        assert_eq!((wilcoxon(&[]), wilcoxon(&[0.0, -0.0])), (None, None));
        assert_eq!(wilcoxon(&[1.0, -1.0]), Some(1.0));
        let balanced: Vec<f64> = (0..60).map(|i| if i % 2 == 0 { 0.5 } else { -0.5 }).collect();
        assert_eq!(wilcoxon(&balanced), Some(1.0));
    }

    #[test]
    fn where_nothing_differs_p_is_below_5_percent_as_often() {
        let mut stream = Seed(3).stream("null", 0);
        for n in [12, 60] {
            let rejected = (0..4000)
                .filter(|_| {
                    let differences: Vec<f64> = (0..n).map(|_| stream.normal()).collect();
                    wilcoxon(&differences).unwrap() < 0.05
                })
                .count();
            assert!((rejected as f64 / 4000.0 - 0.05).abs() < 0.012, "{rejected} of 4000 at {n}");
        }
    }
}
