//! How long steps took, which no run repeats: beside the tables, not among them.

use super::grid::{Style, draw};
use std::time::Duration;

/// The name of the file.
pub const STEP_TIMES: &str = "step_times.md";

/// The table of rows with the times of all their steps.
pub fn step_times(rows: &[(&str, Vec<Duration>)], style: Style) -> String {
    let head = ["milliseconds a step", "p50", "p95", "max", "steps"].map(str::to_owned);
    let drawn = |(name, times): &(&str, Vec<Duration>)| {
        let mut sorted = times.clone();
        sorted.sort_unstable();
        let at = |share: f64| {
            let last = sorted.len().saturating_sub(1);
            let time = sorted.get((share * last as f64).round() as usize);
            time.map_or_else(|| "-".to_owned(), |time| format!("{:.2}", 1e3 * time.as_secs_f64()))
        };
        vec![(*name).to_owned(), at(0.5), at(0.95), at(1.0), sorted.len().to_string()]
    };
    draw(style, &head, rows.iter().map(drawn).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_sorted_times() {
        let times: Vec<Duration> = (0..=100).rev().map(Duration::from_millis).collect();
        let text = step_times(&[("a", times), ("none", Vec::new())], Style::Markdown);
        let row = |name: &str| -> Vec<String> {
            let line = text.lines().find(|line| line.contains(&format!("| {name} "))).unwrap();
            line.split('|').map(|cell| cell.trim().to_owned()).filter(|cell| !cell.is_empty()).collect()
        };
        assert_eq!(row("a"), ["a", "50.00", "95.00", "100.00", "101"]);
        assert_eq!(row("none"), ["none", "-", "-", "-", "0"]);
    }
}
