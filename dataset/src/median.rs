//! The middle of some numbers.

/// The median: of an even count the mean of the middle two, of nothing none.
pub fn median(values: Vec<f64>) -> Option<f64> {
    let sorted = sorted(values);
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(if sorted.len() % 2 == 1 { upper } else { (sorted[sorted.len() / 2 - 1] + upper) / 2.0 })
}

/// The upper median: of an even count the greater of the middle two, of nothing none.
pub fn upper_median(values: Vec<f64>) -> Option<f64> {
    let sorted = sorted(values);
    sorted.get(sorted.len() / 2).copied()
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        let cases = [
            (vec![], None, None),
            (vec![3.0, 1.0, 2.0], Some(2.0), Some(2.0)),
            (vec![4.0, 1.0, 2.0, 3.0], Some(2.5), Some(3.0)),
        ];
        for (values, mean, upper) in cases {
            assert_eq!((median(values.clone()), upper_median(values)), (mean, upper));
        }
    }
}
