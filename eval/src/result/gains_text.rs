//! Gains over the reference as Markdown: what is told of skewed differences, and which of them hold among all.

use super::gain::Gain;
use super::grid::{Style, UNDEFINED, draw};
use super::holm::{SIGNIFICANT, holm};
use super::metric::Metric;
use super::table::Table;
use super::table_text::Sheet;

/// The scores that have a table of gains.
const OF: [Metric; 3] = [Metric::Ate, Metric::AteUmeyama, Metric::Heading];

const HEAD: [&str; 10] = [
    "Method",
    "Mean",
    "95% BCa",
    "Median",
    "Seeds better",
    "Wilcoxon p",
    "Holm p",
    "Five best seeds' share",
    "Geometric mean",
    "Seeds for 5%",
];

/// A method's gain in one score; `None` where no seed has both scores.
struct Row<'a> {
    method: &'a str,
    metric: Metric,
    gain: Option<Gain>,
    /// Adjusted over all rows of the three scores.
    holm: Option<f64>,
}

/// A table for each of ATE, ATE (Umeyama) and heading, of all rows that differ from the reference on any seed; nothing for one seed, or
/// where there is no reference.
pub fn gains(table: &Table) -> String {
    let sheets = sheets(table);
    let Some((told, _)) = sheets.first() else { return String::new() };
    let drawn = sheets.iter().map(|(_, sheet)| {
        format!("\n{}\n\n{}\n", sheet.title, draw(Style::Markdown, &sheet.head, sheet.rows.clone()))
    });
    format!("\n{told}\n{}", drawn.collect::<String>())
}

/// The same as grids, each under what it says of all; means that hold stand between `**`.
pub fn sheets(table: &Table) -> Vec<(String, Sheet)> {
    let (Some(reference), 2..) = (table.reference(), table.seeds().len()) else { return Vec::new() };
    let rows = rows(table, reference);
    let tests = rows.iter().filter(|row| row.holm.is_some()).count();
    let block = |metric: &Metric| {
        let rows: Vec<&Row<'_>> = rows.iter().filter(|row| row.metric == *metric).collect();
        let unit = metric.heading() + metric.arrow();
        let title = format!("{}, gains over {reference}, {unit}", table.name());
        let rows = rows.iter().map(|row| texts(row, table.seeds().len())).collect::<Vec<_>>();
        let head = HEAD.map(str::to_owned).to_vec();
        (!rows.is_empty()).then_some(Sheet { title, head, rows })
    };
    let told = format!(
        "Gains are differences to {reference} on the same seed. Means are bold where Holm's p over these {tests} tests is below \
         {SIGNIFICANT}."
    );
    OF.iter().filter_map(block).map(|sheet| (told.clone(), sheet)).collect()
}

fn rows<'a>(table: &'a Table, reference: &str) -> Vec<Row<'a>> {
    let methods = || table.methods().iter().filter(|method| *method != reference);
    let metrics = OF.iter().filter(|metric| table.metrics().contains(metric));
    let mut rows: Vec<Row<'_>> = metrics
        .flat_map(|&metric| methods().map(move |method| (metric, method)))
        .map(|(metric, method)| {
            let gain = table.paired(method, metric).as_ref().and_then(Gain::of);
            Row { method, metric, gain, holm: None }
        })
        .filter(|row| row.gain.as_ref().is_none_or(|gain| gain.p.is_some()))
        .collect();
    let p_of = |row: &Row<'_>| row.gain.as_ref().and_then(|gain| gain.p);
    let adjusted = holm(&rows.iter().filter_map(p_of).collect::<Vec<_>>());
    let tested = rows.iter_mut().filter(|row| row.gain.is_some());
    tested.zip(adjusted).for_each(|(row, p)| row.holm = Some(p));
    rows
}

fn texts(row: &Row<'_>, seeds: usize) -> Vec<String> {
    let Some(gain) = &row.gain else {
        let undefined = HEAD[1..].iter().map(|_| UNDEFINED.to_owned());
        return std::iter::once(row.method.to_owned()).chain(undefined).collect();
    };
    let value = |value: f64| row.metric.display(value);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| UNDEFINED.to_owned());
    let mean = value(gain.mean.mean);
    let holds = row.holm.is_some_and(|p| p < SIGNIFICANT);
    let counted = if gain.seeds < seeds { format!(" (n={})", gain.seeds) } else { String::new() };
    vec![
        row.method.to_owned(),
        if holds { format!("**{mean}**{counted}") } else { mean + &counted },
        or_dash(gain.interval.map(|(low, high)| format!("{} to {}", value(low), value(high)))),
        value(gain.median),
        format!("{} of {}", gain.better, gain.seeds),
        or_dash(gain.p.map(p_text)),
        or_dash(row.holm.map(p_text)),
        or_dash(gain.best_share.map(|share| format!("{:.0}%", share * 100.0))),
        or_dash(gain.geometric_change.map(percent)),
        or_dash(gain.seeds_for_5_percent.map(|seeds| seeds.to_string())),
    ]
}

/// Four digits.
pub(crate) fn p_text(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".to_owned() } else { format!("{p:.4}") }
}

/// With its sign, zero without.
fn percent(change: f64) -> String {
    let text = format!("{:+.1}%", change * 100.0);
    if text == "-0.0%" || text == "+0.0%" { "0.0%".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::super::run::{Outcome, Run};
    use super::super::table::tests::{METHODS, run};
    use super::*;
    use vantage_dataset::Seed;

    /// Twelve seeds of odometry, the reference, a method and the control; the method gains `by[seed]` of the reference's ATE, and on
    /// half the seeds 0.001 of its heading.
    fn table(by: [f64; 12]) -> Table {
        let mut runs: Vec<Run> = Vec::new();
        for (seed, by) in by.into_iter().enumerate() {
            let heading = if seed % 2 == 0 { 0.001 } else { -0.0011 };
            let scores =
                [(1.0 + 0.01 * seed as f64, 0.1), (0.5, 0.05), (0.5 - by, 0.05 - heading), (0.5, 0.05)];
            for (method, (ate, yaw)) in METHODS.into_iter().chain(["uninformative"]).zip(scores) {
                runs.push(run(method, seed as u64, &[(Metric::Ate, ate), (Metric::Heading, yaw)]));
            }
        }
        of(runs)
    }

    fn of(runs: Vec<Run>) -> Table {
        let methods = [METHODS[0], METHODS[1], METHODS[2], "uninformative"];
        let seeds: Vec<Seed> = (0..12).map(Seed).collect();
        let metrics = [Metric::Ate, Metric::Heading];
        Table::new("trajectory", &methods, Some(METHODS[1]), &metrics, &seeds, runs).unwrap()
    }

    fn steady() -> [f64; 12] {
        std::array::from_fn(|seed| 0.1 + 0.01 * seed as f64)
    }

    fn cells(text: &str, method: &str, nth: usize) -> Vec<String> {
        let start = format!("| {method} ");
        let line = text.lines().filter(|line| line.starts_with(&start)).nth(nth).unwrap();
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
    }

    #[test]
    fn what_holds_among_all_rows_is_bold_and_rows_that_never_differ_are_left_out() {
        let text = gains(&table(steady()));
        let told = "Gains are differences to geometric on the same seed. Means are bold where Holm's p over these 4 tests";
        assert!(text.starts_with(&format!("\n{told}")), "{text}");
        let ate = cells(&text, METHODS[2], 0);
        assert_eq!([&ate[1], &ate[3], &ate[4]], ["**-0.1550**", "-0.1550", "12 of 12"]);
        assert_eq!([&ate[5], &ate[6]], ["0.0005", "0.0020"], "Holm over 4: 4 times 2 in 2^12");
        assert_eq!([&ate[7], &ate[9]], ["51%", "17"]);
        let bounds: Vec<f64> = ate[2].split(" to ").map(|bound| bound.parse().unwrap()).collect();
        assert!(bounds[0] > -0.18 && bounds[0] < -0.155 && bounds[1] > -0.155 && bounds[1] < -0.13, "{text}");
        let heading = cells(&text, METHODS[2], 1);
        assert!(!heading[1].contains('*') && heading[6].parse::<f64>().unwrap() > 0.05, "{text}");
        assert!(text.contains("gains over geometric, Heading [deg] ↓\n"), "{text}");
        assert!(!text.contains("Umeyama") && !text.contains("uninformative"), "{text}");
    }

    #[test]
    fn a_mean_that_one_seed_makes_is_not_bold() {
        let mut few = [0.001; 12];
        (0..12).for_each(|seed| few[seed] *= if seed % 2 == 0 { 1.0 } else { -1.1 } * (seed + 1) as f64);
        few[3] = 0.5;
        let ate = cells(&gains(&table(few)), METHODS[2], 0);
        assert!(ate[1] == "-0.0412" && ate[7] == "108%", "{ate:?}");
    }

    #[test]
    fn undefined_scores_are_dashes_and_fewer_seeds_are_counted() {
        let mut runs: Vec<Run> = table(steady()).runs().cloned().collect();
        for run in runs.iter_mut().filter(|run| run.method == METHODS[0] || run.seed == Seed(5)) {
            run.outcome = Outcome::Failed("diverged".into());
            run.scores.clear();
        }
        let text = gains(&of(runs));
        assert!(cells(&text, METHODS[0], 0)[1..].iter().all(|cell| cell == UNDEFINED), "{text}");
        let own = cells(&text, METHODS[2], 0);
        assert!(own[1].ends_with("** (n=11)") && own[4] == "11 of 11", "{text}");
        assert!(text.contains("over these 2 tests") && !text.contains("NaN"), "{text}");
    }

    #[test]
    fn one_seed_and_no_reference_have_no_gains() {
        assert_eq!(gains(&table(steady()).on(&[Seed(1)])), "");
        let runs = (0..2).map(|seed| run("a", seed, &[(Metric::Ate, 1.0)])).collect();
        let alone = Table::new("t", &["a"], None, &[Metric::Ate], &[Seed(0), Seed(1)], runs).unwrap();
        assert_eq!(gains(&alone), "");
    }

    #[test]
    fn small_numbers_are_told_as_such() {
        assert_eq!([p_text(0.00009), p_text(0.0412)], ["< 0.0001", "0.0412"]);
        assert_eq!([percent(-0.2816), percent(0.05), percent(-0.0001)], ["-28.2%", "+5.0%", "0.0%"]);
    }
}
