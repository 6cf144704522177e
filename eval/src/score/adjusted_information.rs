//! Adjusted mutual information of two clusterings (Vinh, Epps and Bailey 2010), as scikit-learn computes it.
//!
//! ```text
//! AMI = (MI - E[MI]) / ((H(truth) + H(predicted)) / 2 - E[MI])
//! ```
//!
//! The expectation is over all clusterings with clusters of the same sizes: each count of items in two clusters is hypergeometric.

use super::clustering::Contingency;
use std::collections::BTreeMap;

/// 1 for equal partitions, 0 in expectation for random ones; `None` for no item.
///
/// # Panics
/// If there is not one label of each kind an item.
pub fn adjusted_information(truth: &[usize], predicted: &[usize]) -> Option<f64> {
    assert_eq!(truth.len(), predicted.len(), "each item needs both labels");
    if truth.is_empty() {
        return None;
    }
    let table = Contingency::new(truth, predicted);
    if table.is_bijection() {
        return Some(1.0);
    }
    let (mi, truth_entropy, predicted_entropy) = table.information();
    let expected = expected_information(&table.truth, &table.predicted);
    // Above 0, but for rounding: only partitions that are equal whatever their labels reach the mean of the entropies.
    let most = (0.5 * (truth_entropy + predicted_entropy) - expected).max(f64::EPSILON);
    Some((mi - expected) / most)
}

/// `E[MI]` for clusters of these sizes, nats (Eq. 24a of the paper).
fn expected_information(truth: &[usize], predicted: &[usize]) -> f64 {
    let n: usize = truth.iter().sum();
    let log_factorials = log_factorials(n);
    let fact = |count: usize| log_factorials[count];
    let (of_truth, of_predicted) = (by_size(truth), by_size(predicted));
    let mut expected = 0.0;
    for (&a, &clusters) in &of_truth {
        for (&b, &others) in &of_predicted {
            let both = fact(a) + fact(b) + fact(n - a) + fact(n - b) - fact(n);
            let term = |count: usize| {
                let share = count as f64 / n as f64;
                let information = libm::log(n as f64 * count as f64 / (a as f64 * b as f64));
                let ways = fact(count) + fact(a - count) + fact(b - count) + fact(n + count - a - b);
                share * information * libm::exp(both - ways)
            };
            let least = (a + b).saturating_sub(n).max(1);
            expected += (clusters * others) as f64 * (least..=a.min(b)).map(term).sum::<f64>();
        }
    }
    expected
}

/// How many clusters are of each size.
fn by_size(sizes: &[usize]) -> BTreeMap<usize, usize> {
    let mut counts = BTreeMap::new();
    for &size in sizes {
        *counts.entry(size).or_insert(0) += 1;
    }
    counts
}

/// `log i!` for `i` from 0 to `n`.
fn log_factorials(n: usize) -> Vec<f64> {
    let mut sum = 0.0;
    std::iter::once(0.0)
        .chain((1..=n).map(|i| {
            sum += libm::log(i as f64);
            sum
        }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    #[test]
    fn equal_partitions_are_one_and_nothing_is_undefined() {
        assert_eq!(adjusted_information(&[], &[]), None);
        for labels in [&[0, 0, 1, 2][..], &[0, 0], &[0, 1, 2], &[7]] {
            let renamed: Vec<usize> = labels.iter().map(|label| 9 - label).collect();
            assert_eq!(adjusted_information(labels, &renamed), Some(1.0), "{labels:?}");
        }
        let singles = adjusted_information(&[0, 0, 1, 1], &[0, 1, 2, 3]).unwrap();
        assert!(singles.abs() < 1e-12, "{singles}");
    }

    #[test]
    fn the_expectation_is_the_mean_over_all_orders() {
        let (truth, predicted) = ([0, 0, 0, 1, 1, 2], [0, 0, 1, 1, 1, 1]);
        let table = Contingency::new(&truth, &predicted);
        let mut stream = Seed(1).stream("orders", 0);
        let (mut mean, mut shuffled) = (0.0, predicted);
        for _ in 0..20_000 {
            stream.shuffle(&mut shuffled);
            mean += Contingency::new(&truth, &shuffled).information().0 / 20_000.0;
        }
        let expected = expected_information(&table.truth, &table.predicted);
        assert_relative_eq!(expected, mean, max_relative = 0.02);
    }
}
