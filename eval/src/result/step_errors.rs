//! How far off the newest position is after each step.

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
pub fn step_errors(rows: &[StepErrors<'_>]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(std::iter::once("step").chain(rows.iter().map(|(name, _)| *name)))?;
    for step in 0..rows.iter().map(|(_, errors)| errors.len()).max().unwrap_or(0) {
        let of_row = |errors: &[f64]| errors.get(step).map_or(String::new(), |error| format!("{error:.6}"));
        let errors = rows.iter().map(|(_, errors)| of_row(errors));
        writer.write_record(std::iter::once(step.to_string()).chain(errors))?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_end_where_their_shortest_seed_does() {
        let short = over_seeds(&[vec![3.0, 0.0, 1.0], vec![4.0, 0.0]]);
        let csv = step_errors(&[("short", short), ("a, b", over_seeds(&[vec![1.0, 2.0, 0.5]]))]).unwrap();
        let expected = "step,short,\"a, b\"\n0,3.535534,1.000000\n1,0.000000,2.000000\n2,,0.500000\n";
        assert_eq!(String::from_utf8(csv).unwrap(), expected);
    }
}
