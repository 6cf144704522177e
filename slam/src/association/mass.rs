//! Sums of masses, and what of them is kept.

use super::limits::Limits;

/// `log sum exp`; negative infinity of nothing.
pub(crate) fn log_sum(logs: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + libm::log(logs.map(|log| libm::exp(log - largest)).sum())
}

/// Which of these masses are kept, the largest first, and the share of all that is not. The largest always is; what is not a number is none.
pub(super) fn prune(logs: &[f64], limits: &Limits) -> (Vec<usize>, f64) {
    let mut order: Vec<usize> = (0..logs.len()).filter(|i| logs[*i].is_finite()).collect();
    let total = log_sum(order.iter().map(|i| logs[*i]));
    order.sort_by(|a, b| logs[*b].total_cmp(&logs[*a]));
    let share = |i: usize| libm::exp(logs[i] - total);
    let enough = order.iter().take_while(|i| share(**i) >= limits.least_weight).count();
    let kept = enough.max(1).min(limits.hypotheses.max(1)).min(order.len());
    let dropped = order[kept..].iter().map(|i| share(*i)).sum();
    order.truncate(kept);
    (order, dropped)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_dropped_is_counted_and_the_largest_stays() {
        let logs = [0.1_f64, 0.6, 0.3].map(libm::log);
        let limits = |hypotheses, least_weight| Limits { hypotheses, least_weight, merging: None };
        let (kept, dropped) = prune(&logs, &limits(2, 0.0));
        assert_eq!(kept, [1, 2]);
        assert!((dropped - 0.1).abs() < 1e-15);
        let (kept, dropped) = prune(&logs, &limits(9, 0.9));
        assert_eq!(kept, [1]);
        assert!((dropped - 0.4).abs() < 1e-15);
        assert_eq!(prune(&[], &limits(9, 0.0)), (vec![], 0.0));
        assert_eq!(prune(&[f64::NEG_INFINITY], &limits(9, 0.0)), (vec![], 0.0));
        let (kept, dropped) = prune(&[f64::NAN, logs[1], logs[0]], &limits(9, 0.0));
        assert_eq!((kept, dropped), (vec![1, 2], 0.0));
    }
}
