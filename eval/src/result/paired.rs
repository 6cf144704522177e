//! Paired differences: a method's score less the reference's on the same seed.

use super::better::Better;
use super::distribution::incomplete_beta;
use super::metric::Metric;
use super::run::Run;
use super::statistics::{Mean, quantile};
use super::wilcoxon::wilcoxon;
use vantage_dataset::Seed;

/// Differences by seed, at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Paired {
    metric: Metric,
    differences: Vec<(Seed, f64)>,
    /// The method's and the reference's, in the same order.
    scores: Vec<(f64, f64)>,
}

impl Paired {
    /// Of runs on the same seeds, over those on which both scores are defined; `None` where that is none.
    pub fn of(metric: Metric, method: &[Run], reference: &[Run]) -> Option<Self> {
        let score = |run: &Run| run.scores.get(&metric).copied();
        let both = |(own, other): (&Run, &Run)| Some((own.seed, (score(own)?, score(other)?)));
        let (seeds, scores): (Vec<Seed>, Vec<(f64, f64)>) =
            method.iter().zip(reference).filter_map(both).unzip();
        let differences = scores.iter().map(|(own, other)| own - other);
        let differences = seeds.into_iter().zip(differences).collect();
        (!scores.is_empty()).then_some(Self { metric, differences, scores })
    }

    /// What they are differences of.
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// The differences, in the order of the seeds.
    pub fn differences(&self) -> Vec<f64> {
        self.differences.iter().map(|(_, difference)| *difference).collect()
    }

    /// The method's score and the reference's, in the order of the seeds.
    pub fn scores(&self) -> &[(f64, f64)] {
        &self.scores
    }

    /// The reference's mean over these seeds.
    pub fn reference_mean(&self) -> Option<f64> {
        Mean::of(&self.scores.iter().map(|(_, reference)| *reference).collect::<Vec<_>>())
            .map(|mean| mean.mean)
    }

    /// Two-sided p-value of Wilcoxon's signed ranks; `None` where all differences are zero.
    pub fn p(&self) -> Option<f64> {
        wilcoxon(&self.differences())
    }

    /// How many seeds have both scores.
    pub fn seeds(&self) -> usize {
        self.differences.len()
    }

    /// Their mean, summed in the order of the seeds.
    pub fn mean(&self) -> Option<Mean> {
        Mean::of(&self.differences())
    }

    /// On how many seeds the method is better than the reference; of a score that has a target, none.
    pub fn better(&self) -> usize {
        let better = |difference: f64| match self.metric.better() {
            Better::Lower => difference < 0.0,
            Better::Higher => difference > 0.0,
            Better::Near(_) => false,
        };
        self.differences.iter().filter(|(_, difference)| better(*difference)).count()
    }

    /// Whether seeds agree with the sign of the mean: all of them, or more than a fair coin would bring about (two-sided sign
    /// test at 5%; seeds without a difference are left out).
    pub fn seeds_agree(&self) -> bool {
        let count =
            |sign: f64| self.differences.iter().filter(|(_, difference)| difference * sign > 0.0).count();
        let sign = self.mean().map_or(0.0, |mean| mean.mean);
        let (with, against) = (count(sign), count(-sign));
        // P(X >= with) of the binomial law with one half
        against == 0 || incomplete_beta(with as f64, against as f64 + 1.0, 0.5) < 0.025
    }

    /// Rising, equal ones by seed.
    pub fn sorted(&self) -> Vec<(Seed, f64)> {
        let mut sorted = self.differences.clone();
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        sorted
    }

    /// Their median.
    pub fn median(&self) -> Option<f64> {
        quantile(&self.sorted().iter().map(|(_, difference)| *difference).collect::<Vec<_>>(), 0.5)
    }

    /// The seed in the middle of them, the lower one of two.
    pub fn median_seed(&self) -> Option<Seed> {
        self.sorted().get((self.differences.len() - 1) / 2).map(|(seed, _)| *seed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Table;
    use super::super::table::tests::{METHODS, run};
    use super::*;

    /// ATE of the learned method less the reference's: -0.3, 0.1, -0.1, and none on seed 3.
    fn table() -> Table {
        let learned = [0.2, 0.6, 0.4];
        let mut runs: Vec<_> =
            (0..4).flat_map(|seed| METHODS.map(|method| run(method, seed, &[(Metric::Ate, 0.5)]))).collect();
        for run in runs.iter_mut().filter(|run| run.method == METHODS[2]) {
            match learned.get(run.seed.0 as usize) {
                Some(ate) => run.scores.insert(Metric::Ate, *ate),
                None => run.scores.remove(&Metric::Ate),
            };
        }
        let seeds: Vec<Seed> = (0..4).map(Seed).collect();
        Table::new("trajectory", &METHODS, Some(METHODS[1]), &[Metric::Ate], &seeds, runs).unwrap()
    }

    #[test]
    fn seeds_that_have_both_are_counted_sorted_and_the_middle_one_is_told() {
        let paired = table().paired(METHODS[2], Metric::Ate).unwrap();
        assert_eq!((paired.seeds(), paired.better()), (3, 2));
        assert_eq!(paired.sorted().iter().map(|(seed, _)| seed.0).collect::<Vec<_>>(), [0, 2, 1]);
        assert_eq!(paired.median_seed(), Some(Seed(2)));
        assert!((paired.median().unwrap() + 0.1).abs() < 1e-12);
        assert!((paired.mean().unwrap().mean + 0.1).abs() < 1e-12);
        assert_eq!(paired.scores(), [(0.2, 0.5), (0.6, 0.5), (0.4, 0.5)]);
        assert_eq!((paired.reference_mean(), paired.p()), (Some(0.5), Some(0.75)));
    }

    #[test]
    fn seeds_agree_where_a_coin_would_not() {
        let agree = |better: u64, seeds: u64| {
            let runs = |own: f64, other: f64| -> Vec<Run> {
                let ate = |seed| if seed < better { own } else { other };
                (0..seeds).map(|seed| run("a", seed, &[(Metric::Ate, ate(seed))])).collect()
            };
            Paired::of(Metric::Ate, &runs(0.4, 0.51), &runs(0.5, 0.5)).unwrap().seeds_agree()
        };
        assert!(!agree(21, 40), "P of 21 or more, or 19 or less, is 0.87");
        assert!(!agree(26, 40) && agree(27, 40), "P is 0.081, then 0.038");
        assert!(!agree(7, 8) && agree(8, 9), "P is 0.070, then 0.039");
        assert!(agree(2, 2), "no seed says otherwise");
    }

    #[test]
    fn the_reference_and_tables_without_one_have_none() {
        assert_eq!(table().paired(METHODS[1], Metric::Ate), None);
        assert_eq!(table().paired(METHODS[2], Metric::Heading), None);
        let runs = vec![run("a", 0, &[(Metric::Ate, 1.0)])];
        let alone = Table::new("t", &["a"], None, &[Metric::Ate], &[Seed(0)], runs).unwrap();
        assert_eq!(alone.paired("a", Metric::Ate), None);
    }
}
