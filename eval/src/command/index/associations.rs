//! What scenes say of who is who, side by side.

use super::{UNDEFINED, metres};
use crate::pipeline::GIVEN;
use crate::result::metric::Metric;
use crate::result::paired::Paired;
use crate::result::report::TABLES;
use crate::result::results_file::Results;
use crate::result::statistics::Mean;
use crate::result::table::Table;
use crate::scene_file::associator::{AssociatedBy, AssociatorRow, Told};
use crate::score::association::ASSOCIATION;

/// Name of the page.
pub const ASSOCIATIONS: &str = "associations.md";

/// Bounds of the likeliest hypothesis's weight, by which episodes are counted.
const WEIGHTS: [f64; 6] = [0.0, 0.5, 0.8, 0.95, 0.99, 1.0];

/// A page of all scenes that were associated, Markdown, with links from the folder of results; none where there are none.
pub fn associations(scenes: &[Results]) -> Option<String> {
    let tables: Vec<(&str, &Table)> =
        scenes.iter().filter_map(|of| Some((of.scene.as_str(), of.table(ASSOCIATION)?))).collect();
    if tables.is_empty() {
        return None;
    }
    let mut page = "# Who is who\n\nMade by `bench index`, from the files beside it. What rows and columns are: `docs/association.md`.\n"
        .to_owned();
    for told in Told::ALL {
        page += &format!("\n## Told: `{told}`\n");
        for metric in [Metric::PairF1, Metric::ObjectsFound, Metric::AllRight] {
            page += &format!("\n{}, mean over seeds:\n\n", metric.label());
            page += &by_scene(
                &tables,
                "seeds",
                |table| table.seeds().len().to_string(),
                |table, row| mean(table, &name(told, row), metric),
            );
        }
        for metric in [Metric::AteOfGeometric, Metric::AteOfLearned] {
            page += &format!("\n{} less that of `{GIVEN}`, metres, with 95% intervals:\n\n", metric.label());
            page += &by_scene(
                &tables,
                GIVEN,
                |table| mean(table, GIVEN, metric),
                |table, row| difference(table, &name(told, row), metric),
            );
        }
    }
    page += "\n## Are weights to be trusted?\n\nEpisodes of all scenes by the weight of the likeliest hypothesis: the share where it \
             tells all whole tracklets right, and how many there are.\n\n";
    page += &weights(&tables);
    Some(page)
}

fn name(told: Told, by: AssociatorRow) -> String {
    AssociatedBy { told, by }.to_string()
}

/// A row a scene, a column an associator, with one column before them.
fn by_scene(
    tables: &[(&str, &Table)],
    first: &str,
    first_of: impl Fn(&Table) -> String,
    cell: impl Fn(&Table, AssociatorRow) -> String,
) -> String {
    let rows = AssociatorRow::ALL;
    let mut text = format!("| scene | {first} |");
    text.extend(rows.iter().map(|row| format!(" `{row}` |")));
    text += &format!("\n{}\n", "|---".repeat(rows.len() + 2) + "|");
    for (scene, table) in tables {
        text += &format!("| [{scene}](scenes/{scene}/{TABLES}) | {} |", first_of(table));
        text.extend(rows.iter().map(|row| format!(" {} |", cell(table, *row))));
        text.push('\n');
    }
    text
}

fn mean(table: &Table, row: &str, metric: Metric) -> String {
    let told = |mean: Mean| metres(mean.mean) + &fewer(table, mean.n);
    table.cell(row, metric).mean.map_or_else(|| UNDEFINED.to_owned(), told)
}

/// How many seeds a mean is over, where that is not all.
fn fewer(table: &Table, seeds: usize) -> String {
    if seeds < table.seeds().len() { format!(" (n={seeds})") } else { String::new() }
}

fn difference(table: &Table, row: &str, metric: Metric) -> String {
    let paired = Paired::of(metric, table.runs_of(row), table.runs_of(GIVEN));
    let mean = paired.as_ref().and_then(Paired::mean);
    let told = |mean: Mean| super::with_interval(&mean) + &fewer(table, mean.n);
    mean.map_or_else(|| UNDEFINED.to_owned(), told)
}

/// A row an associator that weighs, a column a range of weights.
fn weights(tables: &[(&str, &Table)]) -> String {
    let ranges: Vec<(f64, f64)> = WEIGHTS.windows(2).map(|bounds| (bounds[0], bounds[1])).collect();
    let mut text = "| row |".to_owned();
    text.extend(ranges.iter().map(|(from, to)| format!(" {from} to {to} |")));
    text += &format!("\n{}\n", "|---".repeat(ranges.len() + 1) + "|");
    for row in Told::ALL.into_iter().flat_map(|told| AssociatorRow::ALL.map(|row| name(told, row))) {
        let runs = tables.iter().flat_map(|(_, table)| table.runs_of(&row));
        let is_one = runs.clone().all(|run| run.scores.get(&Metric::Hypotheses).is_none_or(|n| *n <= 1.0));
        if is_one {
            continue;
        }
        let told: Vec<(f64, f64)> = runs
            .filter_map(|run| {
                Some((*run.scores.get(&Metric::BestWeight)?, *run.scores.get(&Metric::AllRight)?))
            })
            .collect();
        text += &format!("| `{row}` |");
        for &(from, to) in &ranges {
            let is_within = |weight: f64| from <= weight && (weight < to || to >= 1.0);
            let right: Vec<f64> =
                told.iter().filter(|(weight, _)| is_within(*weight)).map(|(_, right)| *right).collect();
            let share = Mean::of(&right).map(|mean| format!("{} of {}", metres(mean.mean), right.len()));
            text += &format!(" {} |", share.unwrap_or_else(|| UNDEFINED.to_owned()));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::run;
    use vantage_dataset::Seed;

    fn scene(name: &str) -> Results {
        let row = |method, seed, f1, weight, right, error| {
            let scores = [
                (Metric::PairF1, f1),
                (Metric::Hypotheses, 2.0),
                (Metric::BestWeight, weight),
                (Metric::AllRight, right),
                (Metric::AteOfGeometric, error),
            ];
            run(method, seed, &scores)
        };
        let runs = vec![
            row(GIVEN, 0, 1.0, 1.0, 1.0, 0.5),
            row(GIVEN, 1, 1.0, 1.0, 1.0, 0.5),
            row("tracklets-hypotheses", 0, 0.5, 0.9, 0.0, 0.6),
            row("tracklets-hypotheses", 1, 1.0, 0.9, 1.0, 0.6),
        ];
        let columns = [
            Metric::PairF1,
            Metric::Hypotheses,
            Metric::BestWeight,
            Metric::AllRight,
            Metric::AteOfGeometric,
        ];
        let methods = [GIVEN, "tracklets-hypotheses"];
        let table = Table::new(ASSOCIATION, &methods, None, &columns, &[Seed(0), Seed(1)], runs).unwrap();
        Results::new(name, "abc", vec![table])
    }

    #[test]
    fn scenes_stand_side_by_side_and_weights_are_counted_over_all() {
        assert_eq!(associations(&[Results::new("silent", "abc", vec![])]), None);
        let page =
            associations(&[scene("one"), Results::new("silent", "abc", vec![]), scene("two")]).unwrap();
        assert!(!page.contains("silent"));
        let lines_of = |scene: &str| -> Vec<&str> {
            let link = format!("| [{scene}](scenes/{scene}/tables.md) |");
            page.lines().filter_map(|line| line.strip_prefix(&link)).collect()
        };
        let of_one = lines_of("one");
        assert_eq!(of_one.len(), 10, "five tables of two levels");
        assert_eq!(of_one[0], " 2 | - | - | - | - | - | - | - | 0.750 | - | - | - |");
        assert_eq!(of_one[3], " 0.500 | - | - | - | - | - | - | - | 0.100 +- 0.000 | - | - | - |");
        assert_eq!(of_one[5], " 2 | - | - | - | - | - | - | - | - | - | - | - |");
        assert_eq!(of_one, lines_of("two"));
        assert!(page.ends_with(
            "|---|---|---|---|---|---|\n| `tracklets-hypotheses` | - | - | 0.500 of 4 | - | - |\n"
        ));
    }
}
