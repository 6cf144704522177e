//! The accuracy gate: fresh results against a committed baseline.
//!
//! Scores are compared run by run: the same method on the same seed, so that what differs between seeds takes no part.
//! Fresh results may be of fewer seeds than the baseline; only those are compared.
//! A score has moved where the mean of its differences is larger than a tolerance, which is above what another processor
//! or driver does to it. It has regressed, or improved, where their whole 95% interval is. Both directions fail: a gain
//! that is not written down hides the next loss.

mod comparison;
mod error;
mod junit;
mod machine;
mod verdict;

pub use comparison::{Comparison, Movement, Shift};
pub use error::GateError;
pub use junit::junit;
pub use machine::Machine;
pub use verdict::Verdict;

use crate::result::results_file::Results;
use crate::result::table::Table;
use vantage_dataset::Seed;

/// Refuses a baseline of another state of the scene or without one of the seeds, before anything is made to be compared
/// with it.
pub fn comparable(baseline: &Results, scene: &str, hash: &str, seeds: &[Seed]) -> Result<(), GateError> {
    of_scene(baseline, scene, hash)?;
    baseline.tables.iter().try_for_each(|table| of_seeds(table, seeds))
}

fn of_scene(baseline: &Results, scene: &str, hash: &str) -> Result<(), GateError> {
    if (baseline.scene.as_str(), baseline.scene_hash.as_str()) == (scene, hash) {
        return Ok(());
    }
    let (baseline, fresh) = (baseline.scene_hash.clone(), hash.to_owned());
    Err(GateError::Scene { scene: scene.to_owned(), baseline, fresh })
}

fn of_seeds(baseline: &Table, seeds: &[Seed]) -> Result<(), GateError> {
    let unknown = seeds.iter().find(|seed| !baseline.seeds().contains(seed));
    unknown.map_or(Ok(()), |seed| Err(GateError::Seed { table: baseline.name().to_owned(), seed: seed.0 }))
}

/// Compares `fresh` with `baseline`, score by score.
pub fn compare(baseline: &Results, fresh: &Results) -> Result<Verdict, GateError> {
    of_scene(baseline, &fresh.scene, &fresh.scene_hash)?;
    let mut comparisons = Vec::new();
    for old in &baseline.tables {
        let Some(new) = fresh.table(old.name()) else {
            comparisons.extend(Comparison::of_tables(Some(old), None));
            continue;
        };
        of_seeds(old, new.seeds())?;
        comparisons.extend(Comparison::of_tables(Some(&old.on(new.seeds())), Some(new)));
    }
    if comparisons.iter().all(|comparison| comparison.baseline.is_none()) {
        return Err(GateError::Nothing);
    }
    let unknown = fresh.tables.iter().filter(|new| baseline.table(new.name()).is_none());
    comparisons.extend(unknown.flat_map(|new| Comparison::of_tables(None, Some(new))));
    Ok(Verdict { comparisons })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::grid::Style;
    use crate::result::metric::Metric;
    use crate::result::run::{Outcome, Run};
    use crate::result::table::tests::{METHODS, run, runs, table};

    fn results(runs: Vec<Run>) -> Results {
        Results::new("tabletop", "abc", vec![table(runs).unwrap()])
    }

    /// Results whose ATE of the learned method is off by so much on each seed.
    fn shifted(by: [f64; 4]) -> Results {
        let mut runs = runs();
        for run in runs.iter_mut().filter(|run| run.method == METHODS[2]) {
            *run.scores.get_mut(&Metric::Ate).unwrap() += by[run.seed.0 as usize];
        }
        results(runs)
    }

    fn on(results: &Results, seeds: &[Seed]) -> Results {
        let tables = results.tables.iter().map(|table| table.on(seeds)).collect();
        Results::new(&results.scene, &results.scene_hash, tables)
    }

    fn verdict(fresh: &Results) -> Verdict {
        compare(&results(runs()), fresh).unwrap()
    }

    fn moved(verdict: &Verdict) -> Vec<(&str, Movement)> {
        let moved = verdict.comparisons.iter().filter(|c| c.movement != Movement::Still);
        moved.map(|c| (c.method.as_str(), c.movement)).collect()
    }

    #[test]
    fn equal_results_pass() {
        let verdict = verdict(&results(runs()));
        assert!(verdict.passed());
        assert_eq!(verdict.comparisons.len(), 3 * 2);
        assert_eq!(
            verdict.report(Style::Terminal(120)),
            "of the means over seeds 0 regressed, 0 improved, 0 moved either way, 0 new, 6 within tolerance\n\
             All 24 scores of single seeds that both have are those of the baseline to the last bit.\n"
        );
    }

    #[test]
    fn a_shift_far_below_the_spread_of_the_seeds_is_seen() {
        // Over the four seeds the ATE itself varies by 0.13: the shift is a tenth of its standard error.
        let small = verdict(&shifted([0.006, 0.007, 0.005, 0.006]));
        assert_eq!(moved(&small), [("viewpoint_dependent", Movement::Regressed)]);
        let moved_one = small.comparisons.iter().find(|c| c.movement == Movement::Regressed);
        let shift = moved_one.and_then(|c| c.shift).unwrap();
        assert!((shift.mean.mean - 0.006).abs() < 1e-12 && shift.differing == 4, "{shift:?}");
        let better = verdict(&shifted([-0.006, -0.007, -0.005, -0.006]));
        assert_eq!(moved(&better), [("viewpoint_dependent", Movement::Improved)]);
        assert!(!better.passed() && better.report(Style::Markdown).contains("CHANGELOG"));
    }

    #[test]
    fn what_another_processor_does_passes_and_is_told() {
        let within = verdict(&shifted([0.0009, -0.0004, 0.0002, 0.0]));
        assert!(within.passed(), "{:?}", moved(&within));
        let report = within.report(Style::Terminal(120));
        assert!(report.contains("3 of 24 scores of single seeds differ"), "{report}");
        assert!(report.contains("seed 0"), "the largest difference is there: {report}");
    }

    #[test]
    fn a_score_of_few_views_may_move_as_much_farther_as_it_is_less_sure() {
        let azimuths = [Metric::ViewpointMedian, Metric::ViewpointByImage];
        let off = |degrees: f64| {
            let score = |seed: u64| 0.1 + degrees.to_radians() + 0.01 * seed as f64;
            let runs = (0..4).map(|seed| run("mine", seed, &azimuths.map(|metric| (metric, score(seed)))));
            let seeds: Vec<Seed> = (0..4).map(Seed).collect();
            let table = Table::new("decoder", &["mine"], None, &azimuths, &seeds, runs.collect()).unwrap();
            Results::new("tabletop", "abc", vec![table])
        };
        let moved = |degrees: f64| -> Vec<Metric> {
            let verdict = compare(&off(0.0), &off(degrees)).unwrap();
            let moved = verdict.comparisons.iter().filter(|c| c.movement != Movement::Still);
            moved.map(|c| c.metric).collect()
        };
        assert_eq!(moved(0.05), []);
        assert_eq!(moved(0.14), [Metric::ViewpointMedian]);
        assert_eq!(moved(0.45), azimuths);
    }

    #[test]
    fn a_count_may_move_by_one_cluster_a_seed() {
        let counted = |clusters: u64| {
            let off = [(Metric::ClusterCount, clusters as f64 / 48.0), (Metric::Noise, 0.02)];
            let runs = (0..4).map(|seed| run("mine", seed, &off));
            let seeds: Vec<Seed> = (0..4).map(Seed).collect();
            let metrics = [Metric::ClusterCount, Metric::Noise];
            let table = Table::new("density", &["mine"], None, &metrics, &seeds, runs.collect()).unwrap();
            Results::new("tabletop", "abc", vec![table])
        };
        let passes = |before, after| compare(&counted(before), &counted(after)).unwrap().passed();
        assert!(passes(3, 4) && passes(4, 3));
        assert!(!passes(3, 5) && !passes(5, 3));
    }

    #[test]
    fn one_seed_gone_astray_is_not_lost_in_the_interval() {
        let astray = verdict(&shifted([0.0, 0.0, 1.0, 0.0]));
        assert_eq!(moved(&astray), [("viewpoint_dependent", Movement::Unclear)]);
        let report = astray.report(Style::Markdown);
        assert!(!astray.passed() && report.contains("1 of 4, most on seed 2"), "{report}");
    }

    #[test]
    fn a_failed_run_is_a_regression_even_if_the_mean_gains() {
        let mut worse = runs();
        let failed = worse.iter_mut().find(|r| r.method == "odometry" && r.seed == Seed(3)).unwrap();
        failed.outcome = Outcome::Failed("diverged".into());
        failed.scores.clear();
        let worse = results(worse);
        assert_eq!(verdict(&worse).count(Movement::Regressed), 2);
        let report = verdict(&worse).report(Style::Markdown);
        assert!(report.contains("REGRESSED") && !report.contains("no run has it any more"), "{report}");
        assert_eq!(compare(&worse, &results(runs())).unwrap().count(Movement::Improved), 2);
    }

    #[test]
    fn what_is_gone_regressed_and_what_is_new_is_said() {
        let only = |methods: &[&str]| {
            let runs = runs().into_iter().filter(|r| methods.contains(&r.method.as_str())).collect();
            let seeds: Vec<Seed> = (0..4).map(Seed).collect();
            let metrics = [Metric::Ate, Metric::Heading];
            let table = Table::new("trajectory", methods, Some(methods[0]), &metrics, &seeds, runs);
            Results::new("tabletop", "abc", vec![table.unwrap()])
        };
        let (less, all) = (only(&METHODS[..2]), only(&METHODS));
        let other = compare(&less, &only(&METHODS[2..])).unwrap();
        assert_eq!((other.count(Movement::Regressed), other.count(Movement::New)), (4, 2));
        assert!(other.report(Style::Terminal(120)).contains("No score of a single seed is in both"));
        let lacking = compare(&all, &less).unwrap();
        assert_eq!(lacking.count(Movement::Regressed), 2);
        assert_eq!(
            lacking.report(Style::Terminal(250)).matches("REGRESSED: no run has it any more").count(),
            2
        );
        assert_eq!(compare(&less, &all).unwrap().count(Movement::New), 2);
        let empty = Results::new("tabletop", "abc", vec![]);
        assert_eq!(compare(&all, &empty).unwrap().count(Movement::Regressed), 6);
        assert_eq!(compare(&empty, &all), Err(GateError::Nothing));
    }

    #[test]
    fn other_scenes_and_seeds_are_not_compared() {
        let other = Results::new("tabletop", "abd", vec![table(runs()).unwrap()]);
        assert!(matches!(compare(&results(runs()), &other), Err(GateError::Scene { .. })));
        let four: Vec<Seed> = (0..4).map(Seed).collect();
        assert_eq!(comparable(&other, "tabletop", "abd", &four), Ok(()));
        assert!(matches!(comparable(&other, "tabletop", "abc", &four), Err(GateError::Scene { .. })));
        assert_eq!(comparable(&other, "tabletop", "abd", &four[..3]), Ok(()));
        let five: Vec<Seed> = (0..5).map(Seed).collect();
        let unknown = Err(GateError::Seed { table: "trajectory".to_owned(), seed: 4 });
        assert_eq!(comparable(&other, "tabletop", "abd", &five), unknown);
        let three = on(&results(runs()), &four[..3]);
        assert!(matches!(compare(&three, &results(runs())), Err(GateError::Seed { seed: 3, .. })));
    }

    #[test]
    fn fewer_seeds_are_compared_with_theirs_alone() {
        let two = [Seed(1), Seed(3)];
        let equal = verdict(&on(&results(runs()), &two));
        assert!(equal.passed() && equal.report(Style::Terminal(120)).contains("All 12 scores"));
        let astray = on(&shifted([9.0, 0.0, 9.0, 0.0]), &two);
        assert!(verdict(&astray).passed(), "seeds 0 and 2 are not compared");
        let shifted = on(&shifted([0.0, 0.006, 0.0, 0.006]), &two);
        assert_eq!(moved(&verdict(&shifted)), [("viewpoint_dependent", Movement::Regressed)]);
    }
}
