//! What came of the hypotheses of a map.

use super::bootstrap::bca_interval;
use super::effect::is_certain;
use super::holm::holm;
use super::metric::Metric;
use super::results_file::Results;
use super::statistics::Mean;
use super::wilcoxon::wilcoxon;
use crate::scene_file::hypothesis::{Expectation, Hypothesis};
use crate::scene_file::map::MapFile;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;
use vantage_dataset::Seed;

/// What came of a hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The mean difference of the ATE, metres.
    pub mean: Mean,
    /// Its BCa interval of 95%; `None` where there is none.
    pub interval: Option<(f64, f64)>,
    /// Wilcoxon's p after Holm's correction over the hypotheses of the map that expect less or more.
    pub p: Option<f64>,
    /// What follows.
    pub verdict: Verdict,
}

/// Whether a hypothesis held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As expected.
    Holds,
    /// The opposite.
    Fails,
    /// Neither for certain.
    Undecided,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Undecided => "undecided",
        })
    }
}

/// Fewer differences bound none.
const FEWEST: usize = 10;

/// The outcome of each hypothesis, in their order; `None` where a row is not there or no seed has both.
pub fn outcomes(map: &MapFile, results: &Results) -> Vec<Option<Outcome>> {
    let differences: Vec<Vec<f64>> =
        map.hypotheses.iter().map(|hypothesis| differences(map, results, hypothesis)).collect();
    let tested = |i: &usize| matches!(map.hypotheses[*i].expects, Expectation::Less | Expectation::More);
    let numbers: Vec<usize> = (0..differences.len()).filter(tested).collect();
    let raw: Vec<Option<f64>> = numbers.iter().map(|i| wilcoxon(&differences[*i])).collect();
    // One that cannot be tested was asked all the same.
    let corrected = holm(&raw.iter().map(|p| p.unwrap_or(1.0)).collect::<Vec<_>>());
    let tested = numbers.into_iter().zip(corrected).zip(raw).filter(|(_, raw)| raw.is_some());
    let p: BTreeMap<usize, f64> = tested.map(|(corrected, _)| corrected).collect();
    let outcome = |(i, (hypothesis, differences)): (usize, (&Hypothesis, &Vec<f64>))| {
        let mean = Mean::of(differences)?;
        let (interval, p) = (bca_interval(differences), p.get(&i).copied());
        Some(Outcome { verdict: verdict(hypothesis.expects, &mean, interval, p), mean, interval, p })
    };
    map.hypotheses.iter().zip(&differences).enumerate().map(outcome).collect()
}

fn verdict(expects: Expectation, mean: &Mean, interval: Option<(f64, f64)>, p: Option<f64>) -> Verdict {
    let certain = is_certain(interval, p);
    match (expects, interval.filter(|_| mean.n >= FEWEST || !bounds(expects))) {
        (Expectation::Less, _) if certain && mean.mean < 0.0 => Verdict::Holds,
        (Expectation::More, _) if certain && mean.mean > 0.0 => Verdict::Holds,
        (Expectation::Less | Expectation::More, _) if certain => Verdict::Fails,
        (Expectation::AtMost(margin), Some((_, high))) if high < margin => Verdict::Holds,
        (Expectation::AtMost(margin), Some((low, _))) if low > margin => Verdict::Fails,
        (Expectation::Within(margin), Some((low, high))) if low > -margin && high < margin => Verdict::Holds,
        (Expectation::Within(margin), Some((low, high))) if low > margin || high < -margin => Verdict::Fails,
        _ => Verdict::Undecided,
    }
}

/// Whether it holds or fails by its interval alone.
fn bounds(expects: Expectation) -> bool {
    matches!(expects, Expectation::AtMost(_) | Expectation::Within(_))
}

/// The row's ATE less the other's, on each seed the mean over the hypothesis' cells; seeds that lack one of them are left out.
fn differences(map: &MapFile, results: &Results, hypothesis: &Hypothesis) -> Vec<f64> {
    let other = hypothesis.than_in.as_ref().unwrap_or(&hypothesis.panel);
    let mut by_seed: BTreeMap<Seed, Vec<f64>> = BTreeMap::new();
    for value in &hypothesis.at {
        let own = scores(map, results, (&hypothesis.panel, value), &hypothesis.row);
        let than = scores(map, results, (other, value), &hypothesis.than);
        for (seed, own) in own {
            if let Some(than) = than.get(&seed) {
                by_seed.entry(seed).or_default().push(own - than);
            }
        }
    }
    let whole = by_seed.into_values().filter(|differences| differences.len() == hypothesis.at.len());
    whole.map(|differences| differences.iter().sum::<f64>() / differences.len() as f64).collect()
}

fn scores(
    map: &MapFile,
    results: &Results,
    (panel, value): (&str, &Value),
    row: &str,
) -> BTreeMap<Seed, f64> {
    let panel = map.panels.iter().find(|other| other.name == panel);
    let table = panel.and_then(|panel| results.table(&map.cell_name(panel, value)));
    let runs = table.map_or(&[][..], |table| table.runs_of(row));
    runs.iter().filter_map(|run| Some((run.seed, *run.scores.get(&Metric::Ate)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::table::Table;
    use super::super::table::tests::run;
    use super::*;
    use crate::scene_file::parse;
    use std::path::Path;

    fn map(hypotheses: &str) -> MapFile {
        let text = format!(
            "version: 1\nname: m\npurpose: p\nscene: s\nacross: {{ field: robot.laps, over: [1, 2] }}\n\
             estimates: [{{ rows: [geometric] }}]\n\
             panels: [{{ name: a, title: a }}, {{ name: b, title: b }}]\nhypotheses:\n{hypotheses}"
        );
        parse(&text, Path::new("m")).unwrap()
    }

    /// Row `x` is better than `geometric` by 0.1 in panel `a`, and in panel `b` nearly equal.
    fn results(map: &MapFile) -> Results {
        let mut tables = Vec::new();
        for (panel, gain) in map.panels.iter().zip([0.1, 0.0]) {
            for value in &map.across.over {
                let runs = (0..20).flat_map(|seed| {
                    let geometric = 0.5 + 0.01 * ((seed * 7) % 20) as f64;
                    let wobble = 0.001 * ((seed * 3) % 5) as f64 - 0.002;
                    let x = geometric - gain + wobble;
                    [run("geometric", seed, &[(Metric::Ate, geometric)]), run("x", seed, &[(Metric::Ate, x)])]
                });
                let seeds: Vec<Seed> = (0..20).map(Seed).collect();
                let (name, runs) = (map.cell_name(panel, value), runs.collect());
                tables.push(
                    Table::new(&name, &["geometric", "x"], Some("geometric"), &[Metric::Ate], &seeds, runs)
                        .unwrap(),
                );
            }
        }
        Results::new("m", "hash", tables)
    }

    fn verdicts(hypotheses: &str) -> Vec<Option<Verdict>> {
        let map = map(hypotheses);
        outcomes(&map, &results(&map)).into_iter().map(|outcome| Some(outcome?.verdict)).collect()
    }

    #[test]
    fn hypotheses_hold_fail_or_stay_open() {
        let told = verdicts(
            "  - { says: s, panel: a, at: [1, 2], row: x, than: geometric, expects: less }\n  \
               - { says: s, panel: a, at: [1], row: x, than: geometric, expects: more }\n  \
               - { says: s, panel: b, at: [2], row: x, than: geometric, expects: less }\n  \
               - { says: s, panel: b, at: [1], row: x, than: geometric, expects: { within: 0.01 } }\n  \
               - { says: s, panel: a, at: [1], row: x, than: geometric, expects: { within: 0.01 } }\n  \
               - { says: s, panel: a, at: [1], row: x, than: x, than_in: b, expects: less }\n  \
               - { says: s, panel: a, at: [1], row: y, than: x, expects: less }\n  \
               - { says: s, panel: a, at: [1], row: x, than: geometric, expects: { at_most: 0.01 } }\n  \
               - { says: s, panel: a, at: [1], row: geometric, than: x, expects: { at_most: 0.01 } }\n",
        );
        use Verdict::{Fails, Holds, Undecided};
        let expected = [
            Some(Holds),
            Some(Fails),
            Some(Undecided),
            Some(Holds),
            Some(Fails),
            Some(Holds),
            None,
            Some(Holds),
            Some(Fails),
        ];
        assert_eq!(told, expected);
    }

    #[test]
    fn a_difference_is_the_mean_over_the_cells_that_count() {
        let map = map("  - { says: s, panel: a, at: [1, 2], row: x, than: geometric, expects: less }\n");
        let outcome = outcomes(&map, &results(&map)).remove(0).unwrap();
        assert_eq!(outcome.mean.n, 20);
        assert!((outcome.mean.mean + 0.1).abs() < 1e-12, "{outcome:?}");
        assert!(outcome.p.unwrap() < 1e-4);
    }
}
