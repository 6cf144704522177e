//! What estimators of scenes promise, side by side.

use super::{UNDEFINED, metres, scores, spread};
use crate::result::bootstrap::bca_interval;
use crate::result::metric::Metric;
use crate::result::report::TABLES;
use crate::result::results_file::Results;
use crate::result::table::Table;
use crate::scene_file::row::Row;
use crate::score::consistency::{CONSISTENCY, COVERAGE};

/// Name of the page.
pub const CONSISTENCIES: &str = "consistency.md";

/// Scores, and what each should be.
const SCORES: [(Metric, f64); 10] = [
    (Metric::NeesPose, 1.0),
    (Metric::NeesPoseEnd, 1.0),
    (Metric::NeesHeading, 1.0),
    (Metric::NeesObjectCenter, 1.0),
    (Metric::NeesObjectYaw, 1.0),
    (Metric::PositionInside95, 0.95),
    (Metric::HeadingInside95, 0.95),
    (Metric::PoseInside95, 0.95),
    (Metric::ObjectCenterInside95, 0.95),
    (Metric::ObjectYawInside95, 0.95),
];

/// A page of all scenes that have trajectories, Markdown, with links from the folder of results; none where there are none.
pub fn consistencies(scenes: &[Results]) -> Option<String> {
    let tables: Vec<(&str, &Table, Option<&Table>)> = (scenes.iter())
        .filter_map(|of| Some((of.scene.as_str(), of.table(CONSISTENCY)?, of.table(COVERAGE))))
        .collect();
    if tables.is_empty() {
        return None;
    }
    let mut rows = String::new();
    let (mut cells, mut bold) = (0, 0);
    for &(scene, consistency, coverage) in &tables {
        let is_control = |row: &str| row == Row::Uninformative.to_string();
        for row in consistency.methods().iter().filter(|row| !is_control(row)) {
            let seeds = consistency.runs_of(row).iter().filter(|run| run.failure().is_none()).count();
            rows += &format!("| [{scene}](scenes/{scene}/{TABLES}) | `{row}` | {seeds} |");
            for (metric, wanted) in SCORES {
                let of = if metric.is_nees() { Some(consistency) } else { coverage };
                let scored = of.and_then(|table| Some((table, table.cell(row, metric).mean?)));
                let Some((table, mean)) = scored else {
                    rows += &format!(" {UNDEFINED} |");
                    continue;
                };
                let interval = bca_interval(&scores(table, row, metric));
                let is_off = interval.is_some_and(|(low, high)| wanted < low || wanted > high);
                cells += 1;
                bold += usize::from(is_off);
                let spread = if metric.is_nees() { spread(table, row, metric) } else { String::new() };
                rows += &format!(" {} |", cell(mean.mean, interval, is_off) + &spread);
            }
            rows += "\n";
        }
    }
    let mut page = format!(
        "# What is promised, and what is kept\n\nMade by `bench index`, from the files beside it. \
                    What columns are: `docs/scores.md`.\n\n\
                    Means over seeds with 95% BCa intervals; of a NEES in brackets the median and the most of a seed.\n\
                    A NEES above 1 promises too much, one below too little. Of what lies in 95% regions 0.95 is meant.\n\n\
                    The control, whose model says nothing, is left out: it is *geometric*.\n\n\
                    Bold: the interval excludes what is meant. {bold} of {cells} cells are; about {} would be, were all honest and intervals exact.\n\
                    Of 10 to 20 seeds they are too narrow, and one seed that is far off may make a cell bold: look at the brackets.\n\n\
                    | scene | row | seeds |",
        cells / 20
    );
    page.extend(SCORES.iter().map(|(metric, _)| format!(" {} |", metric.label())));
    page += &format!("\n{}\n{rows}", "|---".repeat(SCORES.len() + 3) + "|");
    Some(page)
}

fn cell(mean: f64, interval: Option<(f64, f64)>, is_off: bool) -> String {
    let interval = interval.map(|(low, high)| format!(" [{}, {}]", metres(low), metres(high)));
    let text = metres(mean) + &interval.unwrap_or_default();
    if is_off { format!("**{text}**") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::run;
    use vantage_dataset::Seed;

    #[test]
    fn what_is_off_its_target_is_bold_and_all_rows_but_the_control_are_shown() {
        assert_eq!(consistencies(&[Results::new("silent", "abc", vec![])]), None);
        let methods = ["geometric", "viewpoint_dependent", "uninformative", "azimuth_head"];
        let columns = [Metric::NeesPose, Metric::NeesObjectYaw];
        let scores = |pose, yaw| [(Metric::NeesPose, pose), (Metric::NeesObjectYaw, yaw)];
        let mut runs = Vec::new();
        for (seed, [near, far, yaw]) in
            [[0.9, 2.9, 1.0], [1.0, 3.0, 1.0], [1.1, 3.1, 40.0]].into_iter().enumerate()
        {
            runs.push(run("geometric", seed as u64, &[(Metric::NeesPose, near)]));
            runs.push(run("viewpoint_dependent", seed as u64, &scores(far, yaw)));
            runs.push(run("uninformative", seed as u64, &[(Metric::NeesPose, near)]));
            runs.push(run("azimuth_head", seed as u64, &[(Metric::NeesPose, near)]));
        }
        let seeds = [Seed(0), Seed(1), Seed(2)];
        let table = Table::new(CONSISTENCY, &methods, None, &columns, &seeds, runs).unwrap();
        let inside = (0..).zip([0.98, 0.99, 1.0]);
        let inside = inside
            .map(|(seed, share)| run("geometric", seed, &[(Metric::PositionInside95, share)]))
            .collect();
        let columns = [Metric::PositionInside95];
        let coverage = Table::new(COVERAGE, &["geometric"], None, &columns, &seeds, inside).unwrap();
        let without = consistencies(&[Results::new("one", "abc", vec![table.clone()])]).unwrap();
        assert!(without.contains("1 of 4 cells are;"), "{without}");
        let page = consistencies(&[Results::new("one", "abc", vec![table, coverage])]).unwrap();
        let lines: Vec<&str> = page.lines().filter(|line| line.starts_with("| [one]")).collect();
        let link = "| [one](scenes/one/tables.md)";
        assert_eq!(
            lines,
            [
                format!(
                    "{link} | `geometric` | 3 | 1.000 [0.900, 1.100] (1.0, 1.1) | - | - | - | - | **0.990 [0.980, 1.000]** | - | - | - | - |"
                ),
                format!(
                    "{link} | `viewpoint_dependent` | 3 | **3.000 [2.900, 3.100]** (3.0, 3.1) | - | - | - | 14.000 [1.000, 40.000] (1.0, 40.0) | - | - | - | - | - |"
                ),
                format!(
                    "{link} | `azimuth_head` | 3 | 1.000 [0.900, 1.100] (1.0, 1.1) | - | - | - | - | - | - | - | - | - |"
                ),
            ]
        );
        assert!(
            page.contains("Bold: the interval excludes what is meant. 2 of 5 cells are; about 0 would be,")
        );
    }
}
