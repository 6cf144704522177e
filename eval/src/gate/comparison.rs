//! One score of one method, against the baseline's, run by run.

use crate::result::better::Better;
use crate::result::metric::Metric;
use crate::result::statistics::Mean;
use crate::result::table::Table;
use crate::result::unit::Unit;
use serde::Serialize;
use vantage_dataset::Seed;

/// What became of a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Movement {
    /// Within its tolerance in the mean.
    Still,
    /// Better: the whole interval of the differences is beyond the tolerance, or more runs have the score.
    Improved,
    /// Worse: the whole interval is, or a run that had the score has it no more.
    Regressed,
    /// The mean difference is beyond the tolerance, and its interval is not, or a single seed has none: a few seeds that went astray, as a rule.
    Unclear,
    /// Not in the baseline.
    New,
}

/// Differences to the baseline, over the seeds that have the score in both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shift {
    /// Fresh score less the baseline's.
    pub mean: Mean,
    /// How many of the seeds differ at all.
    pub differing: usize,
    /// The seed that differs most, with the baseline's score and the fresh one.
    pub most: (Seed, f64, f64),
}

/// One compared score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The table.
    pub table: String,
    /// The method.
    pub method: String,
    /// The metric.
    pub metric: Metric,
    /// The baseline's mean; `None` where it has none.
    pub baseline: Option<Mean>,
    /// The fresh mean; `None` where there is none.
    pub fresh: Option<Mean>,
    /// Their differences by seed; `None` where no seed has both.
    pub shift: Option<Shift>,
    /// What became of it.
    pub movement: Movement,
}

impl Comparison {
    /// By method, then metric, whatever either table has.
    pub fn of_tables(old: Option<&Table>, new: Option<&Table>) -> Vec<Self> {
        let cells = |table: Option<&Table>| -> Vec<(String, Metric)> {
            let Some(table) = table else { return Vec::new() };
            let methods = table.methods().iter();
            methods.flat_map(|method| table.metrics().iter().map(|&m| (method.clone(), m))).collect()
        };
        let known = cells(old);
        let unknown = cells(new).into_iter().filter(|cell| !known.contains(cell));
        let name = old.or(new).map_or("", Table::name);
        let all: Vec<_> = known.iter().cloned().chain(unknown).collect();
        let compared = all.into_iter().filter_map(|(method, metric)| {
            let in_baseline = known.contains(&(method.clone(), metric));
            Self::of_cell(name, method, metric, in_baseline, old, new)
        });
        compared.collect()
    }

    fn of_cell(
        table: &str,
        method: String,
        metric: Metric,
        in_baseline: bool,
        old: Option<&Table>,
        new: Option<&Table>,
    ) -> Option<Self> {
        let (before, after) = (scores(old, &method, metric), scores(new, &method, metric));
        let mean = |scores: &[(Seed, Option<f64>)]| {
            Mean::of(&scores.iter().filter_map(|(_, score)| *score).collect::<Vec<_>>())
        };
        let (baseline, fresh) = (mean(&before), mean(&after));
        if baseline.is_none() && fresh.is_none() {
            return None;
        }
        let of = |seed: Seed| after.iter().find(|(other, _)| *other == seed).and_then(|(_, score)| *score);
        let paired: Vec<(Seed, Option<f64>, Option<f64>)> =
            before.iter().map(|&(seed, score)| (seed, score, of(seed))).collect();
        let shift = shift(&paired);
        let lost = paired.iter().any(|(_, old, new)| old.is_some() && new.is_none());
        let won = paired.iter().any(|(_, old, new)| old.is_none() && new.is_some());
        let judged = |score: Option<f64>| score.map(|score| error(metric, score));
        let errors: Vec<_> =
            paired.iter().map(|&(seed, old, new)| (seed, judged(old), judged(new))).collect();
        let movement = match (in_baseline, lost, won, self::shift(&errors)) {
            (false, ..) => Movement::New,
            (_, true, ..) => Movement::Regressed,
            (.., true, _) => Movement::Improved,
            (.., Some(errors)) => movement(metric, errors.mean),
            (.., None) => Movement::Still,
        };
        Some(Self { table: table.to_owned(), method, metric, baseline, fresh, shift, movement })
    }

    /// By how much the mean may differ.
    pub fn tolerance(&self) -> f64 {
        tolerance(self.metric)
    }
}

/// A method's score on each seed.
fn scores(table: Option<&Table>, method: &str, metric: Metric) -> Vec<(Seed, Option<f64>)> {
    let runs = table.map_or(&[][..], |table| table.runs_of(method));
    runs.iter().map(|run| (run.seed, run.scores.get(&metric).copied())).collect()
}

fn shift(paired: &[(Seed, Option<f64>, Option<f64>)]) -> Option<Shift> {
    let both: Vec<(Seed, f64, f64)> =
        paired.iter().filter_map(|&(seed, old, new)| Some((seed, old?, new?))).collect();
    let differences: Vec<f64> = both.iter().map(|(_, old, new)| new - old).collect();
    let size = |(_, old, new): &&(Seed, f64, f64)| (new - old).abs();
    Some(Shift {
        mean: Mean::of(&differences)?,
        differing: differences.iter().filter(|difference| **difference != 0.0).count(),
        most: *both.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?,
    })
}

/// A score as what should be small.
fn error(metric: Metric, score: f64) -> f64 {
    match metric.better() {
        Better::Lower => score,
        Better::Higher => -score,
        Better::Near(target) => (score - target).abs(),
    }
}

/// What a rise of the error makes of a score.
fn movement(metric: Metric, rise: Mean) -> Movement {
    let tolerance = tolerance(metric);
    let (low, high) = rise.interval().unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    match () {
        () if low > tolerance => Movement::Regressed,
        () if high < -tolerance => Movement::Improved,
        () if rise.mean.abs() > tolerance => Movement::Unclear,
        () => Movement::Still,
    }
}

/// Views of each instance that scores are of, in the scenes that tolerances were found in.
const VIEWS: f64 = 16.0;

/// One cluster in the 48 test instances of those scenes, rounded up.
const CLUSTER: f64 = 0.021;

/// Less is taken for rounding: raw scores were seen to differ by up to 0.001 between processors. A score of one view of each instance
/// jumps as much farther as its standard error is larger, and a count of clusters by a whole one.
fn tolerance(metric: Metric) -> f64 {
    if metric == Metric::ClusterCount {
        return CLUSTER;
    }
    let of_all_views = match metric.unit() {
        Unit::Meter => 0.001,
        Unit::Radian => 0.1f64.to_radians(),
        Unit::Decibel | Unit::Nat => 0.1,
        Unit::Ratio => 0.01,
    };
    if metric.is_of_one_view() { of_all_views * VIEWS.sqrt() } else { of_all_views }
}
