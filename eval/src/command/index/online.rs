//! What scenes say of estimates after every step, side by side.

use super::{UNDEFINED, metres, scores, spread, with_interval};
use crate::result::bootstrap::bca_interval;
use crate::result::metric::Metric;
use crate::result::report::TABLES;
use crate::result::results_file::Results;
use crate::result::table::Table;
use crate::score::online::ONLINE;

/// Name of the page.
pub const ONLINES: &str = "online.md";

/// Scores whose means are told.
const SCORES: [Metric; 5] =
    [Metric::NewestPosition, Metric::NeesNewest, Metric::AteAtEnd, Metric::ApartAtEnd, Metric::ApartSettled];

/// A page of all scenes that were estimated after every step, Markdown, with links from the folder of results; none where there are none.
pub fn onlines(scenes: &[Results]) -> Option<String> {
    let tables: Vec<(&str, &Table)> =
        scenes.iter().filter_map(|of| Some((of.scene.as_str(), of.table(ONLINE)?))).collect();
    if tables.is_empty() {
        return None;
    }
    let mut page = "# After every step\n\nMade by `bench index`, from the files beside it. \
                    What columns are: `docs/scores.md`.\n\n\
                    Means over seeds with 95% intervals, of a NEES by BCa, and the most that the settled poses of a seed are apart from those of its whole episode.\n\
                    In brackets the median and the most of a seed.\n\n\
                    | scene | row | seeds |"
        .to_owned();
    page.extend(SCORES.iter().map(|metric| format!(" {} |", metric.label())));
    page += &format!(" most |\n{}\n", "|---".repeat(SCORES.len() + 4) + "|");
    for (scene, table) in tables {
        for row in table.methods() {
            let runs = table.runs_of(row);
            let apart = runs.iter().filter_map(|run| run.scores.get(&Metric::ApartSettled).copied());
            let Some(most) = apart.reduce(f64::max) else { continue };
            let seeds = runs.iter().filter(|run| run.failure().is_none()).count();
            page += &format!("| [{scene}](scenes/{scene}/{TABLES}) | `{row}` | {seeds} |");
            let mean = |metric: &Metric| {
                let Some(mean) = table.cell(row, *metric).mean else { return UNDEFINED.to_owned() };
                match bca_interval(&scores(table, row, *metric)).filter(|_| metric.is_nees()) {
                    Some((low, high)) => {
                        let interval = format!(" [{}, {}]", metres(low), metres(high));
                        metres(mean.mean) + &interval + &spread(table, row, *metric)
                    }
                    None => with_interval(&mean),
                }
            };
            page.extend(SCORES.iter().map(|metric| format!(" {} |", mean(metric))));
            page += &format!(" {} |\n", metres(most));
        }
    }
    Some(page)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::run;
    use vantage_dataset::Seed;

    #[test]
    fn rows_that_were_estimated_after_every_step_stand_side_by_side_with_the_most_of_a_seed() {
        assert_eq!(onlines(&[Results::new("silent", "abc", vec![])]), None);
        let scores = |apart| [(Metric::NewestPosition, 0.5), (Metric::ApartSettled, apart)];
        let of = |seed, apart| run("geometric", seed, &scores(apart));
        let runs =
            vec![of(0, 0.001), of(1, 0.003), run("uninformative", 0, &[]), run("uninformative", 1, &[])];
        let columns = [Metric::NewestPosition, Metric::ApartSettled];
        let methods = ["geometric", "uninformative"];
        let table = Table::new(ONLINE, &methods, None, &columns, &[Seed(0), Seed(1)], runs).unwrap();
        let page = onlines(&[Results::new("one", "abc", vec![table])]).unwrap();
        let lines: Vec<&str> = page.lines().filter(|line| line.starts_with("| [one]")).collect();
        let link = "| [one](scenes/one/tables.md) | `geometric` | 2 |";
        assert_eq!(lines, [format!("{link} 0.500 +- 0.000 | - | - | - | 0.002 +- 0.013 | 0.003 |")]);
    }
}
