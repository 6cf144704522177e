//! The accuracy gate: fresh results against a committed baseline.
//!
//! A number has moved where it differs from the baseline by more than `max(floor, 3 x standard error)`, the standard
//! error being the baseline's own seed-to-seed spread over the square root of its seeds. Both directions fail:
//! a gain that is not written down hides the next loss.

use crate::metric::{Better, Metric, Unit};
use crate::render::{Style, draw};
use crate::results::Results;
use crate::statistics::Mean;
use crate::table::{Summary, Table};
use thiserror::Error;

/// Standard errors of the baseline that a number may move.
const STANDARD_ERRORS: f64 = 3.0;

/// Why fresh results cannot be compared with a baseline.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GateError {
    /// The baseline is of another scene file.
    #[error(
        "the baseline was made from another state of the scene {scene} (hash {baseline}, now {fresh}): run `bench` on \
         it again and commit the new results"
    )]
    Scene {
        /// The scene.
        scene: String,
        /// The baseline's hash.
        baseline: String,
        /// The fresh hash.
        fresh: String,
    },
    /// The baseline has other seeds.
    #[error(
        "table {table} has {fresh} seeds and the baseline {baseline}, or others: compare with the seeds of the scene file"
    )]
    Seeds {
        /// The table.
        table: String,
        /// Seeds of the baseline.
        baseline: usize,
        /// Fresh seeds.
        fresh: usize,
    },
    /// The baseline has no number at all.
    #[error("the baseline holds no number: nothing was compared")]
    Nothing,
}

/// What became of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Movement {
    /// Within its tolerance.
    Still,
    /// Better by more than its tolerance.
    Improved,
    /// Worse by more than its tolerance, undefined on more runs, or gone.
    Regressed,
    /// Not in the baseline.
    New,
}

/// Which number of a cell is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The mean score.
    Mean,
    /// The mean difference to the reference.
    Difference,
}

/// One compared number.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Table, method.
    pub row: (String, String),
    /// The metric.
    pub metric: Metric,
    /// Mean or difference.
    pub quantity: Quantity,
    /// The baseline's number.
    pub baseline: Option<Mean>,
    /// The fresh number.
    pub fresh: Option<Mean>,
    /// By how much it may move.
    pub tolerance: f64,
    /// What became of it.
    pub movement: Movement,
}

/// All compared numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// By table, method, metric, quantity.
    pub comparisons: Vec<Comparison>,
}

/// Compares `fresh` with `baseline`.
pub fn compare(baseline: &Results, fresh: &Results) -> Result<Verdict, GateError> {
    if (&baseline.scene, &baseline.scene_hash) != (&fresh.scene, &fresh.scene_hash) {
        return Err(GateError::Scene {
            scene: fresh.scene.clone(),
            baseline: baseline.scene_hash.clone(),
            fresh: fresh.scene_hash.clone(),
        });
    }
    let mut comparisons = Vec::new();
    let named = |results: &Results, name: &str| results.tables.iter().find(|t| t.name() == name).cloned();
    for old in &baseline.tables {
        let new = named(fresh, old.name());
        if let Some(new) = &new
            && new.seeds() != old.seeds()
        {
            let (baseline, fresh) = (old.seeds().len(), new.seeds().len());
            return Err(GateError::Seeds { table: old.name().to_owned(), baseline, fresh });
        }
        compare_tables(old, new.as_ref(), &mut comparisons);
    }
    if comparisons.iter().all(|c| c.baseline.is_none()) {
        return Err(GateError::Nothing);
    }
    for new in fresh.tables.iter().filter(|new| named(baseline, new.name()).is_none()) {
        comparisons.extend(new.summary().iter().flat_map(|cell| cells(new.name(), None, Some(cell))));
    }
    Ok(Verdict { comparisons })
}

fn compare_tables(old: &Table, new: Option<&Table>, comparisons: &mut Vec<Comparison>) {
    let (before, after) = (old.summary(), new.map(Table::summary).unwrap_or_default());
    let same = |a: &Summary, b: &Summary| (&a.method, a.metric) == (&b.method, b.metric);
    for cell in &before {
        comparisons.extend(cells(old.name(), Some(cell), after.iter().find(|a| same(a, cell))));
    }
    for cell in after.iter().filter(|a| !before.iter().any(|b| same(a, b))) {
        comparisons.extend(cells(old.name(), None, Some(cell)));
    }
}

/// The mean and the difference of one cell, those that either side has.
fn cells(table: &str, old: Option<&Summary>, new: Option<&Summary>) -> Vec<Comparison> {
    let Some(cell) = old.or(new) else { return Vec::new() };
    [Quantity::Mean, Quantity::Difference]
        .into_iter()
        .filter_map(|quantity| {
            let of = |cell: Option<&Summary>| match quantity {
                Quantity::Mean => cell?.mean,
                Quantity::Difference => cell?.difference,
            };
            let (baseline, fresh) = (of(old), of(new));
            if baseline.is_none() && fresh.is_none() {
                return None;
            }
            let tolerance = tolerance(cell.metric, baseline);
            Some(Comparison {
                row: (table.to_owned(), cell.method.clone()),
                metric: cell.metric,
                quantity,
                movement: movement(cell.metric, quantity, baseline, fresh, old.is_some(), tolerance),
                baseline,
                fresh,
                tolerance,
            })
        })
        .collect()
}

/// `max(floor, 3 x standard error)`.
fn tolerance(metric: Metric, baseline: Option<Mean>) -> f64 {
    let spread = baseline.and_then(|mean| mean.standard_error()).unwrap_or(0.0);
    floor(metric).max(STANDARD_ERRORS * spread)
}

/// What no change of accuracy explains: pixels that differ by rounding between processors and drivers.
fn floor(metric: Metric) -> f64 {
    match metric.unit() {
        Unit::Meter => 0.001,
        Unit::Radian => 0.1f64.to_radians(),
        Unit::Decibel => 0.1,
        Unit::Ratio => 0.01,
    }
}

fn movement(
    metric: Metric,
    quantity: Quantity,
    baseline: Option<Mean>,
    fresh: Option<Mean>,
    known: bool,
    tolerance: f64,
) -> Movement {
    let (baseline, fresh) = match (baseline, fresh) {
        (Some(baseline), Some(fresh)) => (baseline, fresh),
        (Some(_), None) => return Movement::Regressed,
        (None, _) if !known => return Movement::New,
        (None, _) => return Movement::Improved,
    };
    let rise = fresh.mean - baseline.mean;
    let gain = match metric.better() {
        Better::Lower => -rise,
        Better::Higher => rise,
        // A gain if it moved nearer to its target, by as much as it moved.
        Better::Near(target) if quantity == Quantity::Mean => {
            rise.abs().copysign((baseline.mean - target).abs() - (fresh.mean - target).abs())
        }
        // A difference to another method says nothing of the target: any change is one to look at.
        Better::Near(_) => -rise.abs(),
    };
    if gain < -tolerance || fresh.n < baseline.n {
        Movement::Regressed
    } else if gain > tolerance || fresh.n > baseline.n {
        Movement::Improved
    } else {
        Movement::Still
    }
}

impl Verdict {
    /// Whether nothing moved.
    pub fn passed(&self) -> bool {
        self.comparisons.iter().all(|c| c.movement == Movement::Still)
    }

    /// How many numbers moved so.
    pub fn count(&self, movement: Movement) -> usize {
        self.comparisons.iter().filter(|c| c.movement == movement).count()
    }

    /// One line, and a table of what moved where something did, worst first.
    pub fn report(&self, style: Style) -> String {
        let [regressed, improved, new, still] =
            [Movement::Regressed, Movement::Improved, Movement::New, Movement::Still].map(|m| self.count(m));
        let line =
            format!("{regressed} regressed, {improved} improved, {new} new, {still} within tolerance\n");
        if self.passed() {
            return line;
        }
        let head = ["Table", "Method", "Number", "Baseline", "Now", "Tolerance", "Verdict"];
        let mut moved: Vec<&Comparison> =
            self.comparisons.iter().filter(|c| c.movement != Movement::Still).collect();
        moved.sort_by_key(|c| match c.movement {
            Movement::Regressed => 0,
            Movement::Improved => 1,
            Movement::New | Movement::Still => 2,
        });
        let rows = moved.into_iter().map(Comparison::cells).collect();
        let remedy = if regressed > 0 {
            "Find out why before going on.\n"
        } else {
            "Better or more than the baseline: run `bench` on the scene, commit its results, and say why in the CHANGELOG.\n"
        };
        format!("{line}\n{}\n\n{remedy}", draw(style, &head.map(str::to_owned), rows))
    }
}

impl Comparison {
    fn cells(&self) -> Vec<String> {
        let value = |mean: Option<Mean>| {
            mean.map_or_else(
                || "-".to_owned(),
                |mean| format!("{} (n={})", self.metric.display(mean.mean), mean.n),
            )
        };
        let number = match self.quantity {
            Quantity::Mean => self.metric.heading(),
            Quantity::Difference => format!("{}, difference", self.metric.heading()),
        };
        let verdict = match self.movement {
            Movement::Still => "still",
            Movement::Improved => "improved: baseline out of date",
            Movement::Regressed => "REGRESSED",
            Movement::New => "new: not in the baseline",
        };
        vec![
            self.row.0.clone(),
            self.row.1.clone(),
            number,
            value(self.baseline),
            value(self.fresh),
            self.metric.display(self.tolerance),
            verdict.to_owned(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::{METHODS, runs, table};
    use crate::table::{Outcome, Run};
    use vantage_dataset::Seed;

    fn results(runs: Vec<Run>) -> Results {
        Results::new("tabletop", "abc", vec![table(runs).unwrap()])
    }

    fn shifted(method: &str, metric: Metric, by: f64) -> Results {
        let mut runs = runs();
        for run in runs.iter_mut().filter(|r| r.method == method) {
            *run.scores.get_mut(&metric).unwrap() += by;
        }
        results(runs)
    }

    fn verdict(fresh: &Results) -> Verdict {
        compare(&results(runs()), fresh).unwrap()
    }

    fn moved(verdict: &Verdict) -> Vec<(&str, Quantity, Movement)> {
        let moved = verdict.comparisons.iter().filter(|c| c.movement != Movement::Still);
        moved.map(|c| (c.row.1.as_str(), c.quantity, c.movement)).collect()
    }

    #[test]
    fn equal_results_pass() {
        let verdict = verdict(&results(runs()));
        assert!(verdict.passed());
        assert_eq!(verdict.comparisons.len(), 3 * 2 + 2 * 2);
        assert_eq!(verdict.report(Style::Terminal), "0 regressed, 0 improved, 0 new, 10 within tolerance\n");
    }

    #[test]
    fn a_mean_may_move_by_its_spread_and_a_paired_difference_by_its_smaller_one() {
        // The standard error of the ATE over the four seeds is 0.065: the mean may move by 0.19, the difference,
        // which is the same on every seed, by the floor only.
        let small = verdict(&shifted("viewpoint_dependent", Metric::Ate, 0.15));
        assert_eq!(moved(&small), [("viewpoint_dependent", Quantity::Difference, Movement::Regressed)]);
        let large = verdict(&shifted("viewpoint_dependent", Metric::Ate, 0.25));
        assert_eq!(moved(&large).len(), 2);
        let within = verdict(&shifted("viewpoint_dependent", Metric::Ate, 0.0009));
        assert!(within.passed(), "{:?}", moved(&within));
    }

    #[test]
    fn gains_are_flagged_too() {
        let verdict = verdict(&shifted("viewpoint_dependent", Metric::Ate, -0.01));
        assert_eq!(moved(&verdict), [("viewpoint_dependent", Quantity::Difference, Movement::Improved)]);
        assert!(!verdict.passed() && verdict.report(Style::Markdown).contains("CHANGELOG"));
    }

    #[test]
    fn a_failed_run_is_a_regression_even_if_the_mean_gains() {
        let mut worse = runs();
        let failed = worse.iter_mut().find(|r| r.method == "odometry" && r.seed == Seed(3)).unwrap();
        failed.outcome = Outcome::Failed("diverged".into());
        failed.scores.clear();
        let verdict = verdict(&results(worse));
        assert_eq!(verdict.count(Movement::Regressed), 4);
        assert!(verdict.report(Style::Markdown).contains("REGRESSED"));
    }

    #[test]
    fn what_is_gone_regressed_and_what_is_new_is_said() {
        let only = |methods: &[&str]| {
            let runs = runs().into_iter().filter(|r| methods.contains(&r.method.as_str())).collect();
            let seeds: Vec<Seed> = (0..4).map(Seed).collect();
            let metrics = [Metric::Ate, Metric::Heading];
            let table = Table::new("trajectory", methods, Some("geometric"), &metrics, &seeds, runs);
            Results::new("tabletop", "abc", vec![table.unwrap()])
        };
        let (less, all) = (only(&METHODS[..2]), only(&METHODS));
        assert_eq!(compare(&all, &less).unwrap().count(Movement::Regressed), 4);
        assert_eq!(compare(&less, &all).unwrap().count(Movement::New), 4);
        let empty = Results::new("tabletop", "abc", vec![]);
        assert_eq!(compare(&all, &empty).unwrap().count(Movement::Regressed), 10);
        assert_eq!(compare(&empty, &all), Err(GateError::Nothing));
    }

    #[test]
    fn other_scenes_and_seeds_are_not_compared() {
        let other = Results::new("tabletop", "abd", vec![table(runs()).unwrap()]);
        assert!(matches!(compare(&results(runs()), &other), Err(GateError::Scene { .. })));
        let seeds: Vec<Seed> = (0..3).map(Seed).collect();
        let fewer = runs().into_iter().filter(|r| r.seed < Seed(3)).collect();
        let metrics = [Metric::Ate, Metric::Heading];
        let table = Table::new("trajectory", &METHODS, Some("geometric"), &metrics, &seeds, fewer).unwrap();
        let fewer = Results::new("tabletop", "abc", vec![table]);
        assert!(matches!(
            compare(&results(runs()), &fewer),
            Err(GateError::Seeds { baseline: 4, fresh: 3, .. })
        ));
    }
}
