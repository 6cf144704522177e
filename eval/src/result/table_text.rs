//! Tables as text, with all their scores.

use super::bootstrap::bca_interval;
use super::grid::{Style, UNDEFINED, draw_in_parts};
use crate::result::metric::Metric;
use crate::result::run::Outcome;
use crate::result::statistics::Mean;
use crate::result::table::{Summary, Table};
use std::collections::BTreeMap;

/// A grid of texts with its title; the first column holds methods.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// What it shows.
    pub title: String,
    /// A text for each column.
    pub head: Vec<String>,
    /// As many for each row.
    pub rows: Vec<Vec<String>>,
}

/// Scores, then paired differences to the reference, each as mean and half width of the 95% interval; then why runs failed.
pub fn tables(table: &Table, style: Style) -> String {
    let drawn = sheets(table)
        .into_iter()
        .map(|sheet| format!("{}\n\n{}", sheet.title, draw_in_parts(style, 2, &sheet.head, &sheet.rows)));
    let drawn: Vec<String> = drawn.collect();
    let failures: String = failures(table).iter().map(|line| format!("\n{line}\n")).collect();
    format!("{}\n{failures}", drawn.join("\n\n"))
}

/// Scores and, where there is a reference, paired differences to it, each as mean and half width of the 95% interval.
pub fn sheets(table: &Table) -> Vec<Sheet> {
    let summary = table.summary();
    let title = format!("{}, {}", table.name(), over(table));
    let mut sheets =
        vec![sheet(table, &summary, title, |cell| score_text(table, cell), table.methods().iter())];
    if let Some(reference) = table.reference() {
        let title = format!("{}, difference to {reference} on the same seed", table.name());
        let others = table.methods().iter().filter(|m| *m != reference);
        sheets.push(sheet(table, &summary, title, difference_text, others));
    }
    sheets
}

/// A line for each reason that runs failed for, with their methods and seeds; none where none did.
pub fn failures(table: &Table) -> Vec<String> {
    let mut reasons: BTreeMap<&str, BTreeMap<&str, Vec<String>>> = BTreeMap::new();
    for run in table.runs() {
        if let Outcome::Failed(reason) = &run.outcome {
            let methods = reasons.entry(reason).or_default();
            methods.entry(&run.method).or_default().push(run.seed.0.to_string());
        }
    }
    let line = |(reason, methods): (&str, BTreeMap<&str, Vec<String>>)| {
        let runs = methods.iter().map(|(method, seeds)| {
            let plural = if seeds.len() == 1 { "" } else { "s" };
            format!("{method} on seed{plural} {}", seeds.join(", "))
        });
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        format!("Failed: {}: {reason}", runs.collect::<Vec<_>>().join("; "))
    };
    reasons.into_iter().map(line).collect()
}

fn sheet<'a>(
    table: &'a Table,
    summary: &[Summary],
    title: String,
    text: impl Fn(&Summary) -> String,
    methods: impl Iterator<Item = &'a String>,
) -> Sheet {
    let shown = table.metrics().iter().filter(|metric| !metric.is_repeated());
    let head = ["Method".to_owned(), "Runs".to_owned()].into_iter();
    let head: Vec<String> = head.chain(shown.map(|metric| metric.heading() + metric.arrow())).collect();
    let rows: Vec<Vec<String>> = methods
        .map(|method| {
            let cells = summary.iter().filter(|cell| cell.method == *method && !cell.metric.is_repeated());
            [method.clone(), runs_text(table, method)].into_iter().chain(cells.map(&text)).collect()
        })
        .collect();
    Sheet { title, head, rows }
}

/// What a table's numbers are over.
pub(super) fn over(table: &Table) -> String {
    match table.seeds().len() {
        1 => "one seed".to_owned(),
        seeds => format!("mean +- 95% interval over {seeds} seeds"),
    }
}

/// `10`, or `10 (1 failed, 2 flagged)`.
pub(super) fn runs_text(table: &Table, method: &str) -> String {
    let runs = table.runs_of(method);
    let count = |is: fn(&Outcome) -> bool| runs.iter().filter(|run| is(&run.outcome)).count();
    let failed = count(|o| matches!(o, Outcome::Failed(_)));
    let flagged = count(|o| matches!(o, Outcome::Flagged(_)));
    let notes: Vec<String> = [(failed, "failed"), (flagged, "flagged")]
        .into_iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("{n} {what}"))
        .collect();
    if notes.is_empty() { runs.len().to_string() } else { format!("{} ({})", runs.len(), notes.join(", ")) }
}

/// The mean, of a NEES with its BCa interval, `1.042 [0.951, 1.203]`; or, of a score whose mean says nothing, `0.906 to 0.982`.
fn score_text(table: &Table, cell: &Summary) -> String {
    let runs = table.runs_of(&cell.method);
    let scores: Vec<f64> = runs.iter().filter_map(|run| run.scores.get(&cell.metric).copied()).collect();
    if let (true, Some(mean), Some((low, high))) = (cell.metric.is_nees(), cell.mean, bca_interval(&scores)) {
        let [mean, low, high] = [mean.mean, low, high].map(|value| cell.metric.display(value));
        return format!("{mean} [{low}, {high}]{}", defined_on(scores.len(), cell.runs));
    }
    if !cell.metric.is_either_extreme() {
        return mean_text(cell.metric, cell.mean, cell.runs);
    }
    let end = |pick: fn(f64, f64) -> f64| scores.iter().copied().reduce(pick);
    let (Some(low), Some(high)) = (end(f64::min), end(f64::max)) else { return UNDEFINED.to_owned() };
    let (low, high) = (cell.metric.display(low), cell.metric.display(high));
    let ends = if low == high { low } else { format!("{low} to {high}") };
    ends + &defined_on(scores.len(), cell.runs)
}

fn difference_text(cell: &Summary) -> String {
    let difference = cell.difference.filter(|_| !cell.metric.is_either_extreme());
    mean_text(cell.metric, difference, cell.runs)
}

/// `0.1234 +- 0.0123`, of one run `0.1234`, with ` (n=9)` where the score is not defined on all runs, or a dash.
pub(super) fn mean_text(metric: Metric, mean: Option<Mean>, runs: usize) -> String {
    let Some(mean) = mean else { return UNDEFINED.to_owned() };
    let half_width = mean.half_width.map(|half| format!(" +- {}", metric.display(half))).unwrap_or_default();
    format!("{}{half_width}{}", metric.display(mean.mean), defined_on(mean.n, runs))
}

fn defined_on(n: usize, runs: usize) -> String {
    if n < runs { format!(" (n={n})") } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::{METHODS, run, runs, table};
    use vantage_dataset::Seed;

    #[test]
    fn markdown_shows_means_differences_dashes_and_counts() {
        let mut runs = runs();
        for run in runs.iter_mut().filter(|r| r.method == "odometry") {
            run.scores.remove(&Metric::Heading);
        }
        runs[2].outcome = Outcome::Failed("no, \"really\"".into());
        runs[2].scores.clear();
        runs[5].outcome = Outcome::Flagged("iteration limit".into());
        let table = table(runs).unwrap();
        let text = tables(&table, Style::Markdown);
        let line = |start: &str, nth: usize| {
            let found: Vec<&str> = text.lines().filter(|l| l.starts_with(start)).collect();
            found[nth].split('|').map(|c| c.trim().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(line("| Method", 0), ["", "Method", "Runs", "ATE [m] ↓", "Heading [deg] ↓", ""]);
        assert_eq!(line("| odometry", 0), ["", "odometry", "4", "1.0000 +- 0.0000", "-", ""]);
        assert_eq!(line("| geometric", 0)[3], "0.6500 +- 0.2054");
        assert_eq!(line("| viewpoint_dependent", 0)[2], "4 (1 failed, 1 flagged)");
        assert_eq!(line("| viewpoint_dependent", 1)[3], "-0.1000 +- 0.0000 (n=3)");
        assert_eq!(text.lines().filter(|l| l.starts_with("| geometric")).count(), 1);
        assert_eq!(
            text.lines().filter(|l| l.starts_with("Failed")).collect::<Vec<_>>(),
            ["Failed: viewpoint_dependent on seed 0: no, \"really\""]
        );
        assert!(!text.contains("NaN") && text.lines().any(|l| l.starts_with("|--")));
    }

    #[test]
    fn scores_that_err_on_either_side_do_not_cancel() {
        let metrics = [Metric::Inside95, Metric::WorstNumberInside95];
        let shares = [("known", 0, 0.92), ("known", 1, 0.98), ("mine", 0, 0.92), ("mine", 1, 0.92)];
        let mut runs = shares.map(|(method, seed, share)| run(method, seed, &metrics.map(|m| (m, share))));
        runs[3].scores.clear();
        let seeds = [Seed(0), Seed(1)];
        let table =
            Table::new("calibration", &["known", "mine"], Some("known"), &metrics, &seeds, runs.to_vec());
        let text = tables(&table.unwrap(), Style::Markdown);
        let rows: Vec<Vec<&str>> =
            text.lines().map(|line| line.split('|').map(str::trim).collect()).collect();
        let cell = |method: &str, nth: usize| {
            rows.iter().filter(|row| row.get(1) == Some(&method)).nth(nth).unwrap()[4]
        };
        assert_eq!(
            [cell("known", 0), cell("mine", 0), cell("mine", 1)],
            ["0.920 to 0.980", "0.920 (n=1)", "-"]
        );
    }

    #[test]
    fn squared_errors_have_intervals_that_follow_their_skew() {
        let of = |(seed, nees): (u64, f64)| run("mine", seed, &[(Metric::NeesPose, nees)]);
        let runs = (0..).zip([0.9, 1.0, 1.1, 1.0, 6.0]).map(of).collect();
        let seeds = [0, 1, 2, 3, 4].map(Seed);
        let table = Table::new("consistency", &["mine"], None, &[Metric::NeesPose], &seeds, runs).unwrap();
        let text = tables(&table, Style::Markdown);
        let cell = text.lines().last().unwrap().split('|').nth(3).unwrap().trim().to_owned();
        let (mean, bounds) = cell.split_once(" [").unwrap();
        let bounds: Vec<f64> =
            bounds.trim_end_matches(']').split(", ").map(|bound| bound.parse().unwrap()).collect();
        assert_eq!(mean, "2.000");
        assert!(bounds[0] > 0.9 && bounds[1] - 2.0 > 2.0 - bounds[0], "{cell}");
    }

    #[test]
    fn what_two_columns_would_say_is_said_once() {
        let metrics = [Metric::Nmi, Metric::VMeasure];
        let runs = vec![run("mine", 0, &metrics.map(|metric| (metric, 0.75)))];
        let table = Table::new("latents", &["mine"], None, &metrics, &[Seed(0)], runs).unwrap();
        let text = tables(&table, Style::Markdown);
        assert!(text.contains("V-measure ↑") && !text.contains("NMI"), "{text}");
        assert_eq!(text.matches("0.750").count(), 1, "{text}");
    }

    #[test]
    fn one_seed_has_no_interval() {
        let runs = runs().into_iter().filter(|run| run.seed == Seed(0)).collect();
        let table =
            Table::new("trajectory", &METHODS, None, &[Metric::Ate, Metric::Heading], &[Seed(0)], runs);
        let text = tables(&table.unwrap(), Style::Markdown);
        assert!(text.starts_with("trajectory, one seed\n") && !text.contains("+-"), "{text}");
    }

    #[test]
    fn the_terminal_shows_the_same_numbers() {
        let text = tables(&table(runs()).unwrap(), Style::Terminal(120));
        assert!(text.contains("0.6500 +- 0.2054") && text.contains('│'), "{text}");
    }
}
