//! The table of scenes: what the learned row changes of the trajectory's error, and whether that is more than chance.

use super::{UNDEFINED, folders, metres};
use crate::result::gain::Gain;
use crate::result::gains_text::p_text;
use crate::result::holm::{SIGNIFICANT, holm};
use crate::result::kind::ResultKind;
use crate::result::metric::Metric;
use crate::result::paired::Paired;
use crate::result::report::TABLES;
use crate::result::results_file::{Results, ResultsError};
use crate::result::table::Table;
use crate::scene_file::row::Row;
use crate::scene_file::row_name::is_learned;
use crate::score::trajectory_scores::TRAJECTORIES;
use std::path::Path;

const HEAD: &str = "\
| scene | seeds | odometry | geometric | learned | paired difference | seeds better | p | told |
|---|---|---|---|---|---|---|---|---|
";

/// A learned row of a scene.
struct Line {
    /// Scene, seeds, and the mean ATE of odometry, geometry and the row, as cells.
    scores: String,
    gain: Option<Gain>,
    seeds_agree: bool,
}

impl Line {
    fn of(table: &Table, method: &str, link: &str) -> Self {
        let ate = |method: &str| {
            table
                .cell(method, Metric::Ate)
                .mean
                .map_or_else(|| UNDEFINED.to_owned(), |mean| metres(mean.mean))
        };
        let paired = table.paired(method, Metric::Ate);
        let [odometry, geometric] = [Row::Odometry, Row::Geometric].map(|row| ate(&row.to_string()));
        let (seeds, scored) = (table.seeds().len(), paired.as_ref().map_or(0, Paired::seeds));
        let seeds = if scored < seeds { format!("{scored} of {seeds}") } else { seeds.to_string() };
        let scores = format!("| {link} | {seeds} | {odometry} | {geometric} | {} |", ate(method));
        let seeds_agree = paired.as_ref().is_some_and(Paired::seeds_agree);
        Self { scores, gain: paired.as_ref().and_then(Gain::of), seeds_agree }
    }

    /// The mean difference, metres; of none after all others.
    fn difference(&self) -> f64 {
        self.gain.as_ref().map_or(f64::INFINITY, |gain| gain.mean.mean)
    }

    /// `gain` or `harm` where interval, signs and the adjusted p-value agree.
    fn told(&self, p: Option<f64>) -> &'static str {
        let interval = self.gain.as_ref().and_then(|gain| gain.interval);
        match interval.filter(|_| self.seeds_agree && p.is_some_and(|p| p < SIGNIFICANT)) {
            Some((_, high)) if high < 0.0 => "gain",
            Some((low, _)) if low > 0.0 => "harm",
            _ => "undecided",
        }
    }

    fn markdown(&self, p: Option<f64>) -> String {
        let Some(gain) = &self.gain else { return format!("{} - | - | - | - |\n", self.scores) };
        let interval = |(low, high)| format!(" [{}, {}]", metres(low), metres(high));
        let difference = metres(gain.mean.mean) + &gain.interval.map(interval).unwrap_or_default();
        let better = format!("{} of {}", gain.better, gain.seeds);
        let p_shown = p.map_or_else(|| UNDEFINED.to_owned(), p_text);
        format!("{} {difference} | {better} | {p_shown} | {} |\n", self.scores, self.told(p))
    }
}

/// All scenes below `root` that have trajectories, Markdown, those that gain most first; links begin with `prefix`.
///
/// Mean ATE in metres; the difference is the learned row's less that of geometry alone on the same seed, with its 95% BCa interval. Wilcoxon's
/// p-values are adjusted by Holm over all rows of this table.
pub fn scene_table(root: &Path, prefix: &str) -> Result<String, ResultsError> {
    let mut lines = Vec::new();
    for folder in folders(root, ResultKind::Scene) {
        let results = Results::read(&folder)?;
        let Some(table) = results.table(TRAJECTORIES) else { continue };
        let learned: Vec<&String> = table.methods().iter().filter(|method| is_learned(method)).collect();
        for method in &learned {
            let label = match learned.len() {
                1 => results.scene.clone(),
                _ => format!("{}, {method}", results.scene),
            };
            let link = format!("[{label}]({prefix}scenes/{}/{TABLES})", results.scene);
            lines.push(Line::of(table, method, &link));
        }
    }
    lines.sort_by(|a, b| a.difference().total_cmp(&b.difference()).then_with(|| a.scores.cmp(&b.scores)));
    let p = |line: &Line| line.gain.as_ref()?.p;
    let mut adjusted = holm(&lines.iter().filter_map(p).collect::<Vec<f64>>()).into_iter();
    let lines = lines.iter().map(|line| line.markdown(p(line).and_then(|_| adjusted.next())));
    Ok(HEAD.to_owned() + &lines.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::run::Run;
    use crate::result::table::tests::run;
    use vantage_dataset::Seed;

    /// A row whose ATE differs from a geometric one of 1 m.
    fn line(differences: &[f64]) -> Line {
        let ates = |method: &str, ate: &dyn Fn(usize) -> f64| -> Vec<Run> {
            (0..differences.len()).map(|i| run(method, i as u64, &[(Metric::Ate, ate(i))])).collect()
        };
        let mut runs = ates("geometric", &|_| 1.0);
        runs.extend(ates("viewpoint_dependent", &|i| 1.0 + differences[i]));
        let seeds: Vec<Seed> = (0..differences.len() as u64).map(Seed).collect();
        let methods = ["geometric", "viewpoint_dependent"];
        let table =
            Table::new(TRAJECTORIES, &methods, Some("geometric"), &[Metric::Ate], &seeds, runs).unwrap();
        Line::of(&table, "viewpoint_dependent", "here")
    }

    #[test]
    fn a_gain_is_told_where_interval_signs_and_p_agree() {
        let gains: Vec<f64> = (0..20).map(|i| -0.01 * f64::from(i) - 0.01).collect();
        let harms: Vec<f64> = gains.iter().map(|d| -d).collect();
        assert_eq!(line(&gains).told(Some(0.01)), "gain");
        assert_eq!(line(&harms).told(Some(0.01)), "harm");
        assert_eq!(line(&gains).told(Some(0.06)), "undecided");
        assert_eq!(line(&gains).told(None), "undecided");
        // A few large gains and many small losses: the interval tells of a gain, the signs do not.
        let few: Vec<f64> = (0..20).map(|i| if i < 8 { -1.0 - 0.1 * f64::from(i) } else { 0.01 }).collect();
        assert!(line(&few).gain.unwrap().interval.unwrap().1 < 0.0);
        assert_eq!(line(&few).told(Some(0.01)), "undecided");
        let even: Vec<f64> = (0..20).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        assert_eq!(line(&even).told(Some(0.01)), "undecided");
    }
}
