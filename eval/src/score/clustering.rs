//! How well predicted clusters agree with true ones: ARI, NMI, V-measure, homogeneity, completeness, purity.
//!
//! Definitions and corner cases are those of scikit-learn. Only the multiset of counts enters, in sorted order, so
//! that renaming labels or reordering items changes no bit.

use std::collections::BTreeMap;

/// Agreement of two labellings of the same items.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterScores {
    /// Adjusted Rand index: 1 for equal partitions, 0 in expectation for random ones; at least -0.5.
    pub ari: f64,
    /// Normalized mutual information, arithmetic mean of the entropies; equals the V-measure.
    pub nmi: f64,
    /// `MI / H(truth)`: each cluster holds one instance only.
    pub homogeneity: f64,
    /// `MI / H(predicted)`: each instance is in one cluster only.
    pub completeness: f64,
    /// Harmonic mean of homogeneity and completeness.
    pub v_measure: f64,
    /// Share of items that are of their cluster's commonest instance.
    pub purity: f64,
}

/// Scores `predicted` against `truth`, one label an item; `None` for no item.
///
/// # Panics
/// If there is not one label of each kind an item.
pub fn cluster_scores(truth: &[usize], predicted: &[usize]) -> Option<ClusterScores> {
    assert_eq!(truth.len(), predicted.len(), "each item needs both labels");
    if truth.is_empty() {
        return None;
    }
    let table = Contingency::new(truth, predicted);
    let (mi, truth_entropy, predicted_entropy) = table.information();
    let share = |entropy: f64| if entropy > 0.0 { (mi / entropy).min(1.0) } else { 1.0 };
    let (homogeneity, completeness) =
        if table.is_bijection() { (1.0, 1.0) } else { (share(truth_entropy), share(predicted_entropy)) };
    let v_measure = match homogeneity + completeness {
        sum if sum > 0.0 => 2.0 * homogeneity * completeness / sum,
        _ => 0.0,
    };
    Some(ClusterScores {
        ari: table.ari(),
        nmi: v_measure,
        homogeneity,
        completeness,
        v_measure,
        purity: table.purity(),
    })
}

/// Counts of items by true and predicted label.
pub(super) struct Contingency {
    /// (count, items of the true label, items of the predicted label), only counts above 0, sorted.
    cells: Vec<(usize, usize, usize)>,
    /// Items of each true label, sorted.
    pub(super) truth: Vec<usize>,
    /// Items of each predicted label, sorted.
    pub(super) predicted: Vec<usize>,
    /// Items of each cluster's commonest true label, summed.
    majority: usize,
    n: usize,
}

impl Contingency {
    pub(super) fn new(truth: &[usize], predicted: &[usize]) -> Self {
        let mut by_truth = BTreeMap::new();
        let mut by_predicted = BTreeMap::new();
        let mut by_both = BTreeMap::new();
        for (&t, &p) in truth.iter().zip(predicted) {
            *by_truth.entry(t).or_insert(0) += 1;
            *by_predicted.entry(p).or_insert(0) += 1;
            *by_both.entry((t, p)).or_insert(0) += 1;
        }
        let mut commonest = BTreeMap::new();
        for ((_, p), &count) in &by_both {
            let most = commonest.entry(p).or_insert(0);
            *most = count.max(*most);
        }
        let majority = commonest.values().sum();
        let mut cells: Vec<_> =
            by_both.iter().map(|((t, p), &count)| (count, by_truth[t], by_predicted[p])).collect();
        let mut truth: Vec<usize> = by_truth.into_values().collect();
        let mut clusters: Vec<usize> = by_predicted.into_values().collect();
        cells.sort_unstable();
        truth.sort_unstable();
        clusters.sort_unstable();
        Self { cells, truth, predicted: clusters, majority, n: predicted.len() }
    }

    /// Whether each true label is one predicted label and the other way round.
    pub(super) fn is_bijection(&self) -> bool {
        self.cells.iter().all(|&(count, t, p)| count == t && count == p)
    }

    /// `2 (tp tn - fn fp) / ((tp + fn)(fn + tn) + (tp + fp)(fp + tn))` over ordered pairs of items.
    fn ari(&self) -> f64 {
        let squares = |counts: &[usize]| counts.iter().map(|&c| (c as i128).pow(2)).sum::<i128>();
        let n = self.n as i128;
        let both = self.cells.iter().map(|&(c, ..)| (c as i128).pow(2)).sum::<i128>();
        let (truth, predicted) = (squares(&self.truth), squares(&self.predicted));
        let (tp, fp, fn_) = (both - n, predicted - both, truth - both);
        let tn = n * n - n - tp - fp - fn_;
        if fp == 0 && fn_ == 0 {
            return 1.0;
        }
        let [tp, fp, fn_, tn] = [tp, fp, fn_, tn].map(|x| x as f64);
        2.0 * (tp * tn - fn_ * fp) / ((tp + fn_) * (fn_ + tn) + (tp + fp) * (fp + tn))
    }

    /// Mutual information, entropy of the truth, entropy of the prediction, nats.
    pub(super) fn information(&self) -> (f64, f64, f64) {
        let n = self.n as f64;
        let entropy = |counts: &[usize]| {
            if counts.len() == 1 {
                return 0.0;
            }
            -counts.iter().map(|&c| c as f64 / n).map(|p| p * libm::log(p)).sum::<f64>()
        };
        let mi = self
            .cells
            .iter()
            .map(|&(c, t, p)| {
                c as f64 / n * (libm::log(c as f64 * n) - libm::log(t as f64) - libm::log(p as f64))
            })
            .sum::<f64>();
        // A sum of rounding errors only.
        let mi = if mi < f64::EPSILON { 0.0 } else { mi };
        (mi, entropy(&self.truth), entropy(&self.predicted))
    }

    fn purity(&self) -> f64 {
        self.majority as f64 / self.n as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use vantage_dataset::Seed;

    fn labels() -> impl Strategy<Value = Vec<(usize, usize)>> {
        proptest::collection::vec((0usize..6, 0usize..5), 1..60)
    }

    fn score(pairs: &[(usize, usize)]) -> ClusterScores {
        let (truth, predicted): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        cluster_scores(&truth, &predicted).unwrap()
    }

    proptest! {
        #[test]
        fn truth_as_answer_is_exactly_perfect(pairs in labels()) {
            let own: Vec<_> = pairs.iter().map(|&(t, _)| (t, 40 - t)).collect();
            let perfect = ClusterScores {
                ari: 1.0, nmi: 1.0, homogeneity: 1.0, completeness: 1.0, v_measure: 1.0, purity: 1.0,
            };
            prop_assert_eq!(score(&own), perfect);
        }

        #[test]
        fn names_and_order_change_no_bit(pairs in labels(), seed: u64) {
            let mut stream = Seed(seed).stream("rename", 0);
            let (mut true_names, mut names): (Vec<usize>, Vec<usize>) = ((0..6).collect(), (10..15).collect());
            stream.shuffle(&mut true_names);
            stream.shuffle(&mut names);
            let mut renamed: Vec<_> = pairs.iter().map(|&(t, p)| (true_names[t], names[p])).collect();
            stream.shuffle(&mut renamed);
            prop_assert_eq!(score(&renamed), score(&pairs));
        }

        #[test]
        fn homogeneity_and_completeness_swap_with_the_roles(pairs in labels()) {
            let swapped: Vec<_> = pairs.iter().map(|&(t, p)| (p, t)).collect();
            let (a, b) = (score(&pairs), score(&swapped));
            assert_relative_eq!(a.homogeneity, b.completeness, epsilon = 1e-12);
            assert_relative_eq!(a.ari, b.ari, epsilon = 1e-12);
            prop_assert!((0.0..=1.0).contains(&a.v_measure) && (-0.5..=1.0).contains(&a.ari));
        }
    }

    #[test]
    fn random_labels_score_about_zero() {
        let mut stream = Seed(3).stream("labels", 0);
        let pairs: Vec<_> = (0..5000).map(|_| (stream.below(10), stream.below(10))).collect();
        let scores = score(&pairs);
        assert!(scores.ari.abs() < 0.005, "{scores:?}");
        assert!(scores.v_measure < 0.01, "{scores:?}");
    }

    #[test]
    fn corner_cases_are_defined() {
        assert_eq!(cluster_scores(&[], &[]), None);
        let one_cluster = cluster_scores(&[0, 0, 1, 1], &[7, 7, 7, 7]).unwrap();
        assert_eq!(
            (one_cluster.ari, one_cluster.homogeneity, one_cluster.completeness),
            (0.0, 0.0, 1.0),
            "{one_cluster:?}"
        );
        let singletons = cluster_scores(&[0, 0, 1, 1], &[0, 1, 2, 3]).unwrap();
        assert_eq!((singletons.ari, singletons.homogeneity, singletons.purity), (0.0, 1.0, 1.0));
    }
}
