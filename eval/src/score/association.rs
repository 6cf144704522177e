//! How right an association is: pairs of detections, objects, loops, and whether its hypotheses hold the truth.
//!
//! Detections that show nothing are left out of pairs and of the adjusted Rand index; of tracklets, those that were never seen whole are left out
//! of what counts tracklets. Objects' numbers say nothing: only what is of one object counts.

use super::adjusted_information::adjusted_information;
use super::clustering::cluster_scores;
use super::embedding::Scores;
use super::identity::identity_f1;
use crate::result::metric::Metric;
use std::collections::{BTreeMap, BTreeSet};
use vantage_slam::Association;

/// The name of the table.
pub const ASSOCIATION: &str = "association";
/// Its columns.
pub const COLUMNS: [Metric; 17] = [
    Metric::PairPrecision,
    Metric::PairRecall,
    Metric::PairF1,
    Metric::Ari,
    Metric::IdentityF1,
    Metric::ObjectsFound,
    Metric::FalseTaken,
    Metric::LoopPrecision,
    Metric::LoopRecall,
    Metric::AllRight,
    Metric::TruthSurvived,
    Metric::BestWeight,
    Metric::BestBrier,
    Metric::HypothesesEntropy,
    Metric::Hypotheses,
    Metric::AteOfGeometric,
    Metric::AteOfLearned,
];

/// Those of an association that others made.
pub const OF_OTHERS: [Metric; 10] = [
    Metric::PairPrecision,
    Metric::PairRecall,
    Metric::PairF1,
    Metric::Ari,
    Metric::Ami,
    Metric::IdentityF1,
    Metric::ObjectsFound,
    Metric::FalseTaken,
    Metric::LoopPrecision,
    Metric::LoopRecall,
];

/// What is true of tracklets.
#[derive(Clone, Debug)]
pub struct TrueTracklets {
    /// The tracklet of each detection.
    pub tracklets: Vec<usize>,
    /// The object that each detection shows; none of one that shows nothing.
    pub shown: Vec<Option<usize>>,
    /// Whether a box of each tracklet is whole.
    pub is_whole: Vec<bool>,
}

impl TrueTracklets {
    /// The object of each tracklet: that of most of its detections, the smaller number of two that are of as many.
    pub fn objects(&self) -> Vec<Option<usize>> {
        let mut counts: Vec<BTreeMap<usize, usize>> = vec![BTreeMap::new(); self.is_whole.len()];
        for (&tracklet, shown) in self.tracklets.iter().zip(&self.shown) {
            if let Some(object) = shown {
                *counts[tracklet].entry(*object).or_default() += 1;
            }
        }
        let most = |counts: &BTreeMap<usize, usize>| {
            counts
                .iter()
                .max_by_key(|(object, count)| (**count, usize::MAX - **object))
                .map(|(object, _)| *object)
        };
        counts.iter().map(most).collect()
    }

    /// The scores of objects told for each tracklet.
    pub fn scores(&self, told: &[Option<usize>]) -> Scores {
        let labels: Vec<Option<usize>> = self.tracklets.iter().map(|&tracklet| told[tracklet]).collect();
        let mut scores = self.of_pairs(&labels);
        scores.extend(identity_f1(&self.shown, &labels).map(|f1| (Metric::IdentityF1, f1)));
        scores.extend(self.of_objects(&labels));
        scores.extend(self.of_loops(told));
        scores
    }

    /// Whether the tracklets that count are told right.
    fn is_right(&self, truth: &[Option<usize>], told: &[Option<usize>]) -> bool {
        let of = |objects: &[Option<usize>]| {
            let counted = objects.iter().zip(&self.is_whole).filter(|(_, is_whole)| **is_whole);
            canonical(counted.map(|(object, _)| *object))
        };
        of(truth) == of(told)
    }

    /// The scores of all hypotheses together.
    pub fn of_hypotheses(&self, association: &Association) -> Scores {
        let truth = self.objects();
        let Some(best) = association.hypotheses.first() else { return Scores::new() };
        let is_right = f64::from(self.is_right(&truth, &best.objects));
        let survived = association.hypotheses.iter().any(|h| self.is_right(&truth, &h.objects));
        let weights = association.hypotheses.iter().map(|h| h.weight).filter(|weight| *weight > 0.0);
        Scores::from([
            (Metric::AllRight, is_right),
            (Metric::TruthSurvived, f64::from(survived)),
            (Metric::BestWeight, best.weight),
            (Metric::BestBrier, (best.weight - is_right).powi(2)),
            (Metric::HypothesesEntropy, weights.map(|weight| weight * libm::log(1.0 / weight)).sum()),
            (Metric::Hypotheses, association.hypotheses.len() as f64),
        ])
    }

    /// Adjusted mutual information of detections, where objects are told for each tracklet.
    pub fn adjusted_information(&self, told: &[Option<usize>]) -> Option<f64> {
        let labels: Vec<Option<usize>> = self.tracklets.iter().map(|&tracklet| told[tracklet]).collect();
        let (truth, told) = self.clusters(&labels);
        adjusted_information(&truth, &told)
    }

    /// The true and the told object of each detection that shows one. What is told to be of nothing is one of its own.
    fn clusters(&self, labels: &[Option<usize>]) -> (Vec<usize>, Vec<usize>) {
        let (mut truth, mut told) = (Vec::new(), Vec::new());
        for (i, (shown, label)) in self.shown.iter().zip(labels).enumerate() {
            if let Some(object) = shown {
                truth.push(*object);
                told.push(label.map_or((1, i), |label| (0, label)));
            }
        }
        let names: BTreeSet<(usize, usize)> = told.iter().copied().collect();
        let names: BTreeMap<(usize, usize), usize> = names.into_iter().zip(0..).collect();
        (truth, told.iter().map(|label| names[label]).collect())
    }

    fn of_pairs(&self, labels: &[Option<usize>]) -> Scores {
        let (truth, told) = self.clusters(labels);
        let pairs_of =
            |counts: BTreeMap<(usize, usize), f64>| counts.values().map(|n| n * (n - 1.0) / 2.0).sum();
        let count = |of: &dyn Fn(usize) -> (usize, usize)| {
            let mut counts = BTreeMap::new();
            (0..truth.len()).for_each(|i| *counts.entry(of(i)).or_insert(0.0) += 1.0);
            counts
        };
        let both: f64 = pairs_of(count(&|i| (truth[i], told[i])));
        let of_truth: f64 = pairs_of(count(&|i| (truth[i], 0)));
        let of_told: f64 = pairs_of(count(&|i| (told[i], 0)));
        let mut scores = Scores::new();
        scores.extend(share(both, of_told).map(|share| (Metric::PairPrecision, share)));
        scores.extend(share(both, of_truth).map(|share| (Metric::PairRecall, share)));
        scores.extend(share(2.0 * both, of_truth + of_told).map(|share| (Metric::PairF1, share)));
        scores.extend(cluster_scores(&truth, &told).map(|found| (Metric::Ari, found.ari)));
        scores
    }

    fn of_objects(&self, labels: &[Option<usize>]) -> Scores {
        let found: BTreeSet<usize> = labels.iter().flatten().copied().collect();
        let seen: BTreeSet<usize> = self.shown.iter().flatten().copied().collect();
        let nothing = self.shown.iter().zip(labels).filter(|(shown, _)| shown.is_none());
        let (all, taken) = nothing
            .fold((0.0, 0.0), |(all, taken), (_, label)| (all + 1.0, taken + f64::from(label.is_some())));
        let mut scores = Scores::new();
        let ratio = share(found.len() as f64, seen.len() as f64);
        scores.extend(ratio.map(|ratio| (Metric::ObjectsFound, ratio)));
        scores.extend(share(taken, all).map(|share| (Metric::FalseTaken, share)));
        scores
    }

    /// A tracklet closes a loop where an earlier one is of its object.
    fn of_loops(&self, told: &[Option<usize>]) -> Scores {
        let truth = self.objects();
        let (mut claimed, mut there, mut right) = (0.0, 0.0, 0.0);
        for tracklet in (0..truth.len()).filter(|tracklet| self.is_whole[*tracklet]) {
            let earlier = |other: &usize| self.is_whole[*other];
            let of = |objects: &[Option<usize>]| -> Option<usize> {
                let object = objects[tracklet]?;
                (0..tracklet).filter(earlier).find(|other| objects[*other] == Some(object))
            };
            let (is_there, first) = (of(&truth), of(told));
            claimed += f64::from(first.is_some());
            there += f64::from(is_there.is_some());
            let is_right =
                first.is_some_and(|first| truth[first].is_some() && truth[first] == truth[tracklet]);
            right += f64::from(is_right);
        }
        let mut scores = Scores::new();
        scores.extend(share(right, claimed).map(|share| (Metric::LoopPrecision, share)));
        scores.extend(share(right, there).map(|share| (Metric::LoopRecall, share)));
        scores
    }
}

fn share(part: f64, all: f64) -> Option<f64> {
    (all > 0.0).then(|| part / all)
}

/// Objects numbered in the order in which they come.
pub fn canonical(objects: impl Iterator<Item = Option<usize>>) -> Vec<Option<usize>> {
    let mut names = BTreeMap::new();
    let mut name = |object: usize| {
        let next = names.len();
        *names.entry(object).or_insert(next)
    };
    objects.map(|object| object.map(&mut name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;
    use vantage_slam::WeightedPartition;

    /// Tracklets of some detections each, of these objects.
    fn truth(objects: &[Option<usize>], detections: usize) -> TrueTracklets {
        let tracklets: Vec<usize> =
            (0..objects.len()).flat_map(|t| std::iter::repeat_n(t, detections)).collect();
        let shown = tracklets.iter().map(|tracklet| objects[*tracklet]).collect();
        TrueTracklets { tracklets, shown, is_whole: vec![true; objects.len()] }
    }

    #[test]
    fn the_truth_under_other_names_is_perfect() {
        let objects = [Some(3), Some(1), None, Some(3), Some(1)];
        let truth = truth(&objects, 4);
        let scores = truth.scores(&[Some(10), Some(0), None, Some(10), Some(0)]);
        for metric in
            [Metric::PairPrecision, Metric::PairRecall, Metric::PairF1, Metric::Ari, Metric::ObjectsFound]
        {
            assert_eq!(scores[&metric], 1.0, "{metric:?}");
        }
        assert_eq!((scores[&Metric::LoopPrecision], scores[&Metric::LoopRecall]), (1.0, 1.0));
        assert_eq!(scores[&Metric::FalseTaken], 0.0);
    }

    #[test]
    fn splits_lower_recall_and_merges_precision() {
        let truth = truth(&[Some(0), Some(1), Some(0), Some(1)], 2);
        let split = truth.scores(&[Some(0), Some(1), Some(2), Some(1)]);
        // Of 12 pairs of one object 8 are left, and all of those that are told.
        assert_eq!(split[&Metric::PairPrecision], 1.0);
        assert_relative_eq!(split[&Metric::PairRecall], 8.0 / 12.0);
        assert_eq!((split[&Metric::ObjectsFound], split[&Metric::LoopRecall]), (1.5, 0.5));
        let merged = truth.scores(&[Some(0); 4]);
        assert_eq!(merged[&Metric::PairRecall], 1.0);
        assert_relative_eq!(merged[&Metric::PairPrecision], 12.0 / 28.0);
        assert_relative_eq!(merged[&Metric::LoopPrecision], 1.0 / 3.0);
        assert_eq!(merged[&Metric::Ari], 0.0);
    }

    #[test]
    fn what_is_taken_for_nothing_joins_nothing() {
        let truth = truth(&[Some(0), None, Some(0)], 2);
        let scores = truth.scores(&[Some(0), Some(1), None]);
        assert_relative_eq!(scores[&Metric::PairRecall], 1.0 / 6.0);
        assert_eq!((scores[&Metric::FalseTaken], scores[&Metric::ObjectsFound]), (1.0, 2.0));
        assert!(!scores.contains_key(&Metric::LoopPrecision), "nothing is taken for a loop");
        assert_eq!(scores[&Metric::LoopRecall], 0.0);
        assert!(TrueTracklets { tracklets: vec![], shown: vec![], is_whole: vec![] }.scores(&[]).is_empty());
    }

    #[test]
    fn random_labels_have_no_adjusted_rand_index() {
        let mut stream = Seed(3).stream("labels", 0);
        let mut mean = 0.0;
        for _ in 0..200 {
            let objects: Vec<Option<usize>> = (0..30).map(|_| Some(stream.below(4))).collect();
            let told: Vec<Option<usize>> = (0..30).map(|_| Some(stream.below(4))).collect();
            mean += truth(&objects, 1).scores(&told)[&Metric::Ari] / 200.0;
        }
        assert!(mean.abs() < 0.02, "{mean}");
    }

    #[test]
    fn hypotheses_are_asked_for_the_truth_and_for_its_weight() {
        let mut truth = truth(&[Some(0), Some(1), Some(0), Some(2)], 1);
        truth.is_whole[3] = false;
        let partition = |weight, objects: [usize; 4]| WeightedPartition {
            weight,
            objects: objects.into_iter().map(Some).collect(),
        };
        let hypotheses = vec![partition(0.75, [0, 1, 1, 3]), partition(0.25, [5, 6, 5, 5])];
        let scores = truth.of_hypotheses(&Association { hypotheses, ..Association::default() });
        assert_eq!((scores[&Metric::AllRight], scores[&Metric::TruthSurvived]), (0.0, 1.0));
        assert_relative_eq!(scores[&Metric::BestBrier], 0.5625);
        assert_relative_eq!(scores[&Metric::HypothesesEntropy], 0.5623, epsilon = 1e-4);
    }
}
