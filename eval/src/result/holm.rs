//! The step-down adjustment of Holm (1979): p-values of several tests, so that one false find among them is as rare as in one test.

/// What a p-value of one test has to be below to count.
pub const SIGNIFICANT: f64 = 0.05;

/// Adjusted p-values, in the order given: the largest of `(m - j) p_(j)` over the `j`-th least up to a test's own, at most 1.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut rising: Vec<usize> = (0..p_values.len()).collect();
    rising.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut adjusted = vec![0.0; p_values.len()];
    let mut largest = 0.0f64;
    for (place, test) in rising.into_iter().enumerate() {
        largest = largest.max((p_values.len() - place) as f64 * p_values[test]).min(1.0);
        adjusted[test] = largest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn adjusted_values_are_those_of_the_rule_in_the_order_given() {
        // R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
        for (own, expected) in holm(&[0.01, 0.04, 0.03, 0.005]).into_iter().zip([0.03, 0.06, 0.06, 0.02]) {
            assert_relative_eq!(own, expected, max_relative = 1e-12);
        }
        assert_eq!(holm(&[0.5, 0.9, 0.4]), [1.0, 1.0, 1.0]);
        assert_eq!((holm(&[0.03]), holm(&[])), (vec![0.03], vec![]));
    }

    #[test]
    fn equal_values_stay_equal() {
        assert_eq!(holm(&[0.02, 0.001, 0.02]), [0.04, 0.003, 0.04]);
    }
}
