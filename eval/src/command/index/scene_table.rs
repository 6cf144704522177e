//! The table of scenes: what the learned row changes of the trajectory's error, and whether that is more than chance.

use super::{UNDEFINED, folders, metres};
use crate::result::effect::Effect;
use crate::result::gain::Gain;
use crate::result::gains_text::p_text;
use crate::result::holm::holm;
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
        Self { scores, gain: paired.as_ref().and_then(Gain::of) }
    }

    /// The mean difference, metres; of none after all others.
    fn difference(&self) -> f64 {
        self.gain.as_ref().map_or(f64::INFINITY, |gain| gain.mean.mean)
    }

    fn markdown(&self, p: Option<f64>) -> String {
        let Some(gain) = &self.gain else { return format!("{} - | - | - | - |\n", self.scores) };
        let interval = |(low, high)| format!(" [{}, {}]", metres(low), metres(high));
        let difference = metres(gain.mean.mean) + &gain.interval.map(interval).unwrap_or_default();
        let better = format!("{} of {}", gain.better, gain.seeds);
        let p_shown = p.map_or_else(|| UNDEFINED.to_owned(), p_text);
        let told = match Effect::of(gain, p) {
            Effect::Lowers => "gain",
            Effect::Raises => "harm",
            Effect::Undecided => "undecided",
        };
        format!("{} {difference} | {better} | {p_shown} | {told} |\n", self.scores)
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
