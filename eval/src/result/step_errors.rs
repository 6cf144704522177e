//! How far off the newest position is after each step.

use std::fmt::Write;

/// The name of the file.
pub const STEP_ERRORS: &str = "step_errors.csv";

/// Of each row, by step: the root mean square over seeds of the errors of the newest position, metres.
pub type StepErrors<'a> = (&'a str, Vec<f64>);

/// Of errors of each seed by step, of the steps that all seeds have.
pub fn over_seeds(seeds: &[Vec<f64>]) -> Vec<f64> {
    let steps = seeds.iter().map(Vec::len).min().unwrap_or(0);
    let at = |i: usize| seeds.iter().map(|errors| errors[i] * errors[i]).sum::<f64>() / seeds.len() as f64;
    (0..steps).map(|i| at(i).sqrt()).collect()
}

/// A line a step and a column a row, empty where a row has fewer steps.
pub fn step_errors(rows: &[StepErrors<'_>]) -> String {
    let mut csv = "step".to_owned();
    for (name, _) in rows {
        csv += &format!(",{name}");
    }
    csv.push('\n');
    for step in 0..rows.iter().map(|(_, errors)| errors.len()).max().unwrap_or(0) {
        csv += &step.to_string();
        for (_, errors) in rows {
            csv.push(',');
            if let Some(error) = errors.get(step) {
                let _ = write!(csv, "{error:.6}");
            }
        }
        csv.push('\n');
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_end_where_their_shortest_seed_does() {
        let short = over_seeds(&[vec![3.0, 0.0, 1.0], vec![4.0, 0.0]]);
        let csv = step_errors(&[("short", short), ("long", over_seeds(&[vec![1.0, 2.0, 0.5]]))]);
        assert_eq!(csv, "step,short,long\n0,3.535534,1.000000\n1,0.000000,2.000000\n2,,0.500000\n");
    }
}
