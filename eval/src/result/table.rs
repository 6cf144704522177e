//! A result table: the raw score of every method on every seed, and what follows from them.

use crate::exit::{Ends, Exit};
use crate::result::metric::Metric;
use crate::result::paired::Paired;
use crate::result::run::Run;
use crate::result::statistics::Mean;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use thiserror::Error;
use vantage_dataset::Seed;

/// Scores of every method on every seed, complete and finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StoredTable", into = "StoredTable")]
pub struct Table {
    name: String,
    methods: Vec<String>,
    reference: Option<String>,
    metrics: Vec<Metric>,
    seeds: Vec<Seed>,
    /// `[method][seed]`.
    runs: Vec<Vec<Run>>,
}

/// One row of a table's summary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// The method.
    pub method: String,
    /// The metric.
    pub metric: Metric,
    /// Runs of the method, failed ones included.
    pub runs: usize,
    /// Over the seeds on which the score is defined; `None` where that is none.
    pub mean: Option<Mean>,
    /// Of the score less the reference's on the same seed, over the seeds on which both are defined; `None` where
    /// that is none, or the table has no reference, or the method is it.
    pub difference: Option<Mean>,
}

/// Why runs make no table.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TableError {
    /// A run is missing: it failed without being recorded.
    #[error("table {table}: no run of {method} on seed {seed}; a failed run has to be recorded as failed")]
    Missing {
        /// The table.
        table: String,
        /// The method.
        method: String,
        /// The seed.
        seed: u64,
    },
    /// A run that is there twice, or of a method or seed the table does not have.
    #[error("table {table}: the run of {method} on seed {seed} is there twice, or not of this table")]
    Unexpected {
        /// The table.
        table: String,
        /// The method.
        method: String,
        /// The seed.
        seed: u64,
    },
    /// A score that is NaN or infinite, not of this table, or of a failed run.
    #[error(
        "table {table}: {method} on seed {seed} scores {value} in {metric:?}, which is not finite, not a metric of \
         this table, or of a failed run"
    )]
    Score {
        /// The table.
        table: String,
        /// The method.
        method: String,
        /// The seed.
        seed: u64,
        /// The metric.
        metric: Metric,
        /// The score.
        value: f64,
    },
    /// The reference is not a method of the table.
    #[error("table {table}: the reference {reference} is not one of its methods")]
    Reference {
        /// The table.
        table: String,
        /// The reference.
        reference: String,
    },
}

impl Ends for TableError {
    fn exit(&self) -> Exit {
        Exit::Bug
    }
}

impl Table {
    /// A table of `methods` (rows, in this order) by `metrics` (columns), over `seeds`, with differences paired by
    /// seed to `reference`. `runs` may come in any order, but has to hold each method on each seed once.
    pub fn new(
        name: &str,
        methods: &[&str],
        reference: Option<&str>,
        metrics: &[Metric],
        seeds: &[Seed],
        runs: Vec<Run>,
    ) -> Result<Self, TableError> {
        let table = name.to_owned();
        if let Some(reference) = reference
            && !methods.contains(&reference)
        {
            return Err(TableError::Reference { table, reference: reference.to_owned() });
        }
        let mut by_seed: BTreeMap<(String, Seed), Run> = BTreeMap::new();
        for run in runs {
            check_scores(&table, metrics, &run)?;
            let key = (run.method.clone(), run.seed);
            let known = methods.contains(&run.method.as_str()) && seeds.contains(&run.seed);
            if !known || by_seed.contains_key(&key) {
                return Err(TableError::Unexpected { table, method: key.0, seed: key.1.0 });
            }
            by_seed.insert(key, run);
        }
        let mut seeds = seeds.to_vec();
        seeds.sort_unstable();
        let row = |method: &&str| -> Result<Vec<Run>, TableError> {
            let run = |seed: &Seed| by_seed.remove(&((*method).to_owned(), *seed)).ok_or(*seed);
            let runs: Result<Vec<Run>, Seed> = seeds.iter().map(run).collect();
            runs.map_err(|seed| TableError::Missing {
                table: table.clone(),
                method: (*method).to_owned(),
                seed: seed.0,
            })
        };
        let runs = methods.iter().map(row).collect::<Result<_, _>>()?;
        Ok(Self {
            name: name.to_owned(),
            methods: methods.iter().map(|&m| m.to_owned()).collect(),
            reference: reference.map(str::to_owned),
            metrics: metrics.to_vec(),
            seeds,
            runs,
        })
    }

    /// Its name, which is also that of its files.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its rows.
    pub fn methods(&self) -> &[String] {
        &self.methods
    }

    /// The method that differences are to.
    pub fn reference(&self) -> Option<&str> {
        self.reference.as_deref()
    }

    /// Its columns.
    pub fn metrics(&self) -> &[Metric] {
        &self.metrics
    }

    /// Its seeds, rising.
    pub fn seeds(&self) -> &[Seed] {
        &self.seeds
    }

    /// All runs, by method, then seed.
    pub fn runs(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().flatten()
    }

    /// The runs of one method, by seed; none for a method the table does not have.
    pub fn runs_of(&self, method: &str) -> &[Run] {
        self.methods.iter().position(|m| m == method).map_or(&[], |i| self.runs[i].as_slice())
    }

    /// The same table over those of its seeds that are in `seeds`.
    pub fn on(&self, seeds: &[Seed]) -> Self {
        let mut table = self.clone();
        table.seeds.retain(|seed| seeds.contains(seed));
        table.runs.iter_mut().for_each(|runs| runs.retain(|run| seeds.contains(&run.seed)));
        table
    }

    /// A method's differences to the reference; `None` where no seed has both scores, or the table has no reference, or the method is
    /// it.
    pub fn paired(&self, method: &str, metric: Metric) -> Option<Paired> {
        let reference = self.reference().filter(|reference| *reference != method)?;
        Paired::of(metric, self.runs_of(method), self.runs_of(reference))
    }

    /// Means and differences, by method, then metric.
    pub fn summary(&self) -> Vec<Summary> {
        let cells = self.methods.iter().flat_map(|method| self.metrics.iter().map(move |m| (method, *m)));
        cells.map(|(method, metric)| self.cell(method, metric)).collect()
    }

    /// Mean and difference of one score of one method.
    pub fn cell(&self, method: &str, metric: Metric) -> Summary {
        let runs = self.runs_of(method);
        let defined: Vec<f64> = runs.iter().filter_map(|run| run.scores.get(&metric).copied()).collect();
        Summary {
            method: method.to_owned(),
            metric,
            runs: runs.len(),
            mean: Mean::of(&defined),
            difference: self.paired(method, metric).and_then(|paired| paired.mean()),
        }
    }
}

fn check_scores(table: &str, metrics: &[Metric], run: &Run) -> Result<(), TableError> {
    let failed = run.failure().is_some();
    let bad = run.scores.iter().find(|(m, v)| failed || !v.is_finite() || !metrics.contains(m));
    bad.map_or(Ok(()), |(&metric, &value)| {
        Err(TableError::Score {
            table: table.to_owned(),
            method: run.method.clone(),
            seed: run.seed.0,
            metric,
            value,
        })
    })
}

/// A table as files hold it: with its summary, which is computed anew when read.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredTable {
    name: String,
    methods: Vec<String>,
    reference: Option<String>,
    metrics: Vec<Metric>,
    seeds: Vec<Seed>,
    runs: Vec<Run>,
    summary: Vec<Summary>,
}

impl From<Table> for StoredTable {
    fn from(table: Table) -> Self {
        Self {
            summary: table.summary(),
            runs: table.runs().cloned().collect(),
            name: table.name,
            methods: table.methods,
            reference: table.reference,
            metrics: table.metrics,
            seeds: table.seeds,
        }
    }
}

impl TryFrom<StoredTable> for Table {
    type Error = TableError;

    fn try_from(stored: StoredTable) -> Result<Self, TableError> {
        let methods: Vec<&str> = stored.methods.iter().map(String::as_str).collect();
        let reference = stored.reference.as_deref();
        Table::new(&stored.name, &methods, reference, &stored.metrics, &stored.seeds, stored.runs)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::run::Outcome;
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    pub(crate) const METHODS: [&str; 3] = ["odometry", "geometric", "viewpoint_dependent"];

    pub(crate) fn run(method: &str, seed: u64, scores: &[(Metric, f64)]) -> Run {
        Run {
            method: method.into(),
            seed: Seed(seed),
            outcome: Outcome::Done,
            scores: scores.iter().copied().collect(),
        }
    }

    /// ATE of the three methods on four seeds; the third is always 0.1 better than the second.
    pub(crate) fn runs() -> Vec<Run> {
        let mut runs = Vec::new();
        for seed in 0..4 {
            let geometric = 0.5 + 0.1 * seed as f64;
            let heading = 0.01 * (seed + 1) as f64;
            for (method, ate) in METHODS.into_iter().zip([1.0, geometric, geometric - 0.1]) {
                runs.push(run(method, seed, &[(Metric::Ate, ate), (Metric::Heading, heading)]));
            }
        }
        runs
    }

    pub(crate) fn table(runs: Vec<Run>) -> Result<Table, TableError> {
        let seeds: Vec<Seed> = (0..4).map(Seed).collect();
        Table::new("trajectory", &METHODS, Some("geometric"), &[Metric::Ate, Metric::Heading], &seeds, runs)
    }

    fn summary(table: &Table, method: &str) -> Summary {
        table.summary().into_iter().find(|s| s.method == method && s.metric == Metric::Ate).unwrap()
    }

    proptest! {
        #[test]
        fn run_order_changes_no_byte(seed: u64) {
            let mut shuffled = runs();
            Seed(seed).stream("order", 0).shuffle(&mut shuffled);
            let bytes = |t: Table| serde_json::to_string(&t).unwrap();
            prop_assert_eq!(bytes(table(shuffled).unwrap()), bytes(table(runs()).unwrap()));
        }
    }

    #[test]
    fn differences_are_paired_by_seed() {
        let table = table(runs()).unwrap();
        let own = summary(&table, "viewpoint_dependent");
        assert_relative_eq!(own.mean.unwrap().mean, 0.55, epsilon = 1e-12);
        let difference = own.difference.unwrap();
        assert_relative_eq!(difference.mean, -0.1, epsilon = 1e-12);
        assert!(difference.half_width.unwrap() < 1e-12 && own.mean.unwrap().half_width.unwrap() > 0.1);
        assert_eq!(summary(&table, "geometric").difference, None);
    }

    #[test]
    fn failed_runs_stay_in_the_denominator() {
        let mut runs = runs();
        let failed =
            runs.iter_mut().find(|r| r.method == "viewpoint_dependent" && r.seed == Seed(3)).unwrap();
        failed.outcome = Outcome::Failed("diverged".into());
        failed.scores.clear();
        let row = summary(&table(runs.clone()).unwrap(), "viewpoint_dependent");
        assert_eq!((row.runs, row.mean.unwrap().n, row.difference.unwrap().n), (4, 3, 3));
        runs.iter_mut().filter(|r| r.method == "viewpoint_dependent").for_each(|r| r.scores.clear());
        let row = summary(&table(runs).unwrap(), "viewpoint_dependent");
        assert_eq!((row.runs, row.mean, row.difference), (4, None, None));
    }

    #[test]
    fn incomplete_doubled_and_undefined_runs_are_refused() {
        let mut missing = runs();
        missing.pop();
        assert!(matches!(table(missing), Err(TableError::Missing { seed: 3, .. })));
        let mut doubled = runs();
        doubled.push(doubled[0].clone());
        assert!(matches!(table(doubled), Err(TableError::Unexpected { seed: 0, .. })));
        for (metric, value) in [(Metric::Ate, f64::NAN), (Metric::Heading, f64::INFINITY), (Metric::Ari, 1.0)]
        {
            let mut bad = runs();
            bad[5].scores.insert(metric, value);
            assert!(matches!(table(bad), Err(TableError::Score { .. })), "{metric:?} {value}");
        }
        let mut failed = runs();
        failed[0].outcome = Outcome::Failed("no answer".into());
        assert!(matches!(table(failed), Err(TableError::Score { .. })));
        let unknown = Table::new("t", &["a"], Some("b"), &[], &[], vec![]);
        assert!(matches!(unknown, Err(TableError::Reference { .. })));
    }

    #[test]
    fn reading_inverts_writing() {
        let table = table(runs()).unwrap();
        let json = serde_json::to_string(&table).unwrap();
        assert_eq!(serde_json::from_str::<Table>(&json).unwrap(), table);
        let tampered = json.replacen("\"seed\":3", "\"seed\":2", 1);
        assert!(serde_json::from_str::<Table>(&tampered).is_err());
    }
}
