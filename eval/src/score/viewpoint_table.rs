//! The table of viewpoint errors, by family.

use super::viewpoint::{ErrorShape, ViewpointSummary};
use crate::result::grid::{Style, UNDEFINED, draw};
use crate::result::metric::Metric;
use std::collections::BTreeMap;

/// Viewpoint errors by family, degrees, with chance beside them; the last row is of all families.
pub fn viewpoint_table(
    by_family: &BTreeMap<String, ViewpointSummary>,
    all: &ViewpointSummary,
    style: Style,
) -> String {
    let head = [
        "Family",
        "Views",
        "Median [deg]",
        "chance",
        "P90 [deg]",
        "chance",
        "< 15 deg",
        "chance",
        "No answer",
    ];
    let named = by_family.iter().map(|(family, summary)| (family.as_str(), summary));
    let rows = named
        .chain([("all", all)])
        .map(|(family, summary)| {
            let value = |shape: Option<ErrorShape>, of: fn(ErrorShape) -> f64, metric: Metric| {
                shape.map_or_else(|| UNDEFINED.to_owned(), |shape| metric.display(of(shape)))
            };
            let (model, chance) = (summary.model, summary.chance);
            let (angle, share) = (Metric::ViewpointMedian, Metric::ViewpointRight);
            vec![
                family.to_owned(),
                summary.trials.to_string(),
                value(model, |s| s.median, angle),
                value(chance, |s| s.median, angle),
                value(model, |s| s.p90, angle),
                value(chance, |s| s.p90, angle),
                value(model, |s| s.right, share),
                value(chance, |s| s.right, share),
                summary.unanswered.to_string(),
            ]
        })
        .collect();
    draw(style, &head.map(str::to_owned), rows) + "\n"
}

#[cfg(test)]
mod tests {
    use super::super::viewpoint::{ViewpointTrial, summarize, summarize_by_family};
    use super::*;
    use vantage_dataset::Symmetry;

    #[test]
    fn viewpoint_errors_stand_beside_chance() {
        let trials = [
            ViewpointTrial { family: "mug".into(), symmetry: Symmetry::None, azimuth: 0.0, found: Some(0.1) },
            ViewpointTrial {
                family: "bowl".into(),
                symmetry: Symmetry::Revolution,
                azimuth: 0.0,
                found: None,
            },
        ];
        let text = viewpoint_table(&summarize_by_family(&trials), &summarize(&trials), Style::Markdown);
        let cells = |start: &str| -> Vec<String> {
            let line = text.lines().find(|l| l.starts_with(start)).unwrap();
            line.split('|').map(|c| c.trim().to_owned()).collect()
        };
        assert_eq!(cells("| mug")[3..9], ["5.730", "90.000", "5.730", "162.000", "1.000", "0.083"]);
        assert_eq!(cells("| bowl")[2..10], ["0", "-", "-", "-", "-", "-", "-", "0"]);
    }
}
