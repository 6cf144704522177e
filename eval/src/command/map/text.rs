//! The tables of a map: what came of its hypotheses, and the rows of each panel.

use crate::result::bootstrap::bca_interval;
use crate::result::effect::is_certain;
use crate::result::gain::Gain;
use crate::result::grid::{Style, UNDEFINED, draw};
use crate::result::holm::holm;
use crate::result::metric::Metric;
use crate::result::outcome::{Outcome, outcomes};
use crate::result::paired::Paired;
use crate::result::results_file::Results;
use crate::result::run::Outcome as Ending;
use crate::result::statistics::Mean;
use crate::result::table::Table;
use crate::result::wilcoxon::wilcoxon;
use crate::scene_file::hypothesis::{Expectation, Hypothesis};
use crate::scene_file::map::MapFile;
use crate::scene_file::panel::Panel;
use crate::scene_file::row::Row;
use crate::scene_file::vary::{Fields, told};

/// Scores that have a table of gains.
const GAINS: [Metric; 3] = [Metric::Ate, Metric::AteUmeyama, Metric::Heading];

/// The text of `tables.md`.
pub fn map_markdown(map: &MapFile, results: &Results) -> String {
    let mut text = format!("# {}\n\n{}\n", map.name, map.purpose.trim());
    text += &hypotheses(map, results);
    for panel in &map.panels {
        let tables: Vec<&Table> =
            map.across.over.iter().filter_map(|value| results.table(&map.cell_name(panel, value))).collect();
        text += &of_panel(map, panel, &tables);
    }
    text
}

fn hypotheses(map: &MapFile, results: &Results) -> String {
    if map.hypotheses.is_empty() {
        return String::new();
    }
    let head = [
        "Hypothesis",
        "Cells",
        "Rows",
        "Expected",
        "Seeds",
        "Difference of the ATE [m]",
        "95%",
        "p (Holm)",
        "Outcome",
    ];
    let row = |(hypothesis, outcome): (&Hypothesis, &Option<Outcome>)| {
        let at: Vec<String> = hypothesis.at.iter().map(told).collect();
        let than = match &hypothesis.than_in {
            Some(panel) => format!("{} in {panel}", hypothesis.than),
            None => hypothesis.than.clone(),
        };
        let expected = match hypothesis.expects {
            Expectation::Less => "less".to_owned(),
            Expectation::More => "more".to_owned(),
            Expectation::AtMost(margin) => format!("at most {margin} m"),
            Expectation::Within(margin) => format!("within {margin} m"),
        };
        let [seeds, difference, interval, p, verdict] = match outcome {
            None => [(); 5].map(|()| UNDEFINED.to_owned()),
            Some(outcome) => [
                outcome.mean.n.to_string(),
                signed(outcome.mean.mean),
                outcome.interval.map_or_else(
                    || UNDEFINED.to_owned(),
                    |(low, high)| format!("{} to {}", signed(low), signed(high)),
                ),
                outcome.p.map_or_else(|| UNDEFINED.to_owned(), probability),
                outcome.verdict.to_string(),
            ],
        };
        vec![
            hypothesis.says.clone(),
            format!("{}, {} {}", hypothesis.panel, map.across.label(), at.join(", ")),
            format!("{} - {than}", hypothesis.row),
            expected,
            seeds,
            difference,
            interval,
            p,
            verdict,
        ]
    };
    let outcomes = outcomes(map, results);
    let rows = map.hypotheses.iter().zip(&outcomes).map(row).collect();
    format!(
        "\n## Hypotheses\n\nAs the map's file states them. *Less* and *more* count where Wilcoxon's p is below 0.05 after Holm's correction over \
         all of them,\nand the interval excludes 0. Bounds go by the interval alone, without a correction.\n\n{}\n",
        draw(Style::Markdown, &head.map(str::to_owned), rows)
    )
}

fn of_panel(map: &MapFile, panel: &Panel, tables: &[&Table]) -> String {
    let mut text = format!("\n## {}: {}\n", panel.name, panel.title);
    if !panel.set.is_empty() {
        text += &format!("\n{}\n", fields(&panel.set));
    }
    for stretch in panel.life.iter().filter(|stretch| stretch.from > 1 || !stretch.set.is_empty()) {
        let set =
            if stretch.set.is_empty() { "the panel's own fields".to_owned() } else { fields(&stretch.set) };
        text += &format!("\nFrom drive {}: {set}\n", stretch.from);
    }
    for estimates in panel.estimates.as_ref().unwrap_or(&map.estimates) {
        let rows: Vec<String> = estimates.rows.iter().map(Row::to_string).collect();
        let model = estimates.model.as_ref().and_then(|model| model.file_name());
        let by = model.map(|name| format!(", by {}", name.display())).unwrap_or_default();
        if !estimates.set.is_empty() {
            text += &format!("\n{}{by}: {}\n", rows.join(", "), fields(&estimates.set));
        }
        if let Some(association) = estimates.association {
            text += &format!("\n{}{by}: who is who by `{association}`\n", rows.join(", "));
        }
    }
    let Some(first) = tables.first() else { return text };
    let head = |first: &str| -> Vec<String> {
        let values = map.across.over.iter().map(|value| format!("{} {}", map.across.label(), told(value)));
        std::iter::once(first.to_owned()).chain(values).collect()
    };
    let methods = first.methods();
    let of_means = [
        Metric::Ate,
        Metric::NeesPose,
        Metric::PositionInside95,
        Metric::Azimuth,
        Metric::PrequentialGain,
        Metric::Ari,
    ];
    // Where rows are told who is who, none has an ARI.
    let is_scored = |metric: &Metric| {
        let has = |table: &&Table| methods.iter().any(|method| table.cell(method, *metric).mean.is_some());
        *metric != Metric::Ari || tables.iter().any(has)
    };
    let of_means = of_means.into_iter().filter(|metric| first.metrics().contains(metric));
    for metric in of_means.filter(is_scored) {
        let row = |method: &String| {
            let cells =
                tables.iter().map(|table| mean(metric, table.cell(method, metric).mean, table.seeds().len()));
            std::iter::once(method.clone()).chain(cells).collect()
        };
        let rows = methods.iter().map(row).collect();
        let seeds = first.seeds().len();
        text += &format!("\n{}, mean +- 95% over {seeds} seeds\n\n", metric.heading());
        text += &draw(Style::Markdown, &head("Row"), rows);
        text += "\n";
    }
    text += &mishaps(tables);
    let Some(reference) = first.reference() else { return text };
    for metric in GAINS {
        let others = [reference.to_owned(), Row::Uninformative.to_string()];
        let differs: Vec<&String> = methods.iter().filter(|method| !others.contains(method)).collect();
        let paired: Vec<Vec<Option<Paired>>> = differs
            .iter()
            .map(|method| tables.iter().map(|table| table.paired(method, metric)).collect())
            .collect();
        text += &format!(
            "\n{} less that of {reference}, on the same seed: mean, 95%, seeds better; bold where Holm's p over this table is below 0.05 and the interval excludes 0\n\n",
            metric.heading()
        );
        text += &draw(Style::Markdown, &head("Row"), gains(metric, &differs, &paired));
        text += "\n";
        if metric == Metric::Ate {
            text +=
                "\nMedian of these differences, and how many seeds would show a mean difference of 5%\n\n";
            text += &draw(Style::Markdown, &head("Row"), medians(metric, &differs, &paired));
            text += "\n";
        }
    }
    text
}

fn fields(set: &Fields) -> String {
    let told = set.iter().map(|(field, value)| format!("`{field}: {}`", told(value)));
    told.collect::<Vec<_>>().join(", ")
}

fn medians(metric: Metric, methods: &[&String], paired: &[Vec<Option<Paired>>]) -> Vec<Vec<String>> {
    let cell = |paired: &Option<Paired>| {
        let Some(gain) = paired.as_ref().and_then(Gain::of) else { return UNDEFINED.to_owned() };
        let seeds = gain.seeds_for_5_percent.map_or_else(|| UNDEFINED.to_owned(), |seeds| seeds.to_string());
        format!("{}, {seeds}", metric.display(gain.median))
    };
    let row = |(method, paired): (&&String, &Vec<Option<Paired>>)| {
        std::iter::once((*method).clone()).chain(paired.iter().map(cell)).collect()
    };
    methods.iter().zip(paired).map(row).collect()
}

fn gains(metric: Metric, methods: &[&String], paired: &[Vec<Option<Paired>>]) -> Vec<Vec<String>> {
    let values = |paired: &Paired| -> Vec<f64> { paired.sorted().iter().map(|(_, value)| *value).collect() };
    let p: Vec<Option<f64>> =
        paired.iter().flatten().map(|paired| wilcoxon(&values(paired.as_ref()?))).collect();
    let defined: Vec<f64> = p.iter().flatten().copied().collect();
    let mut corrected = holm(&defined).into_iter();
    let p: Vec<Option<f64>> = p.into_iter().map(|p| p.and_then(|_| corrected.next())).collect();
    let mut p = p.into_iter();
    let mut cell = |paired: &Option<Paired>| {
        let p = p.next().flatten();
        let Some((paired, mean)) = paired.as_ref().and_then(|paired| Some((paired, paired.mean()?))) else {
            return UNDEFINED.to_owned();
        };
        let shown = |value: f64| metric.display(value);
        let interval = bca_interval(&values(paired));
        let bold = if is_certain(interval, p) { "**" } else { "" };
        let interval =
            interval.map(|(low, high)| format!(" [{}, {}]", shown(low), shown(high))).unwrap_or_default();
        format!("{bold}{}{bold}{interval} {}/{}", shown(mean.mean), paired.better(), paired.seeds())
    };
    let row = |(method, paired): (&&String, &Vec<Option<Paired>>)| {
        std::iter::once((*method).clone()).chain(paired.iter().map(&mut cell)).collect()
    };
    methods.iter().zip(paired).map(row).collect()
}

/// How many runs failed, or ended otherwise than they should; nothing where none did.
fn mishaps(tables: &[&Table]) -> String {
    let runs = || tables.iter().flat_map(|table| table.runs());
    let failed = runs().filter(|run| run.failure().is_some()).count();
    let flagged = runs().filter(|run| matches!(run.outcome, Ending::Flagged(_))).count();
    match (failed, flagged) {
        (0, 0) => String::new(),
        _ => format!("\nOf {} runs {failed} failed, and {flagged} are flagged.\n", runs().count()),
    }
}

/// With the number of seeds that have the score, where some of `all` lack it.
fn mean(metric: Metric, mean: Option<Mean>, all: usize) -> String {
    let Some(mean) = mean else { return UNDEFINED.to_owned() };
    let half = mean.half_width.map(|half| format!(" +- {}", metric.display(half))).unwrap_or_default();
    let some = if mean.n < all { format!(" (n={})", mean.n) } else { String::new() };
    metric.display(mean.mean) + &half + &some
}

fn signed(metres: f64) -> String {
    format!("{metres:+.4}")
}

fn probability(p: f64) -> String {
    if p < 0.0001 { "< 0.0001".to_owned() } else { format!("{p:.4}") }
}
