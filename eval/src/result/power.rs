//! The power of a paired comparison: how many seeds show a difference of a given size.

use super::distribution::normal_quantile;

/// Seeds on which a two-sided test of paired differences at 5% finds a mean difference of `effect` with probability 80%:
/// `((z(0.975) + z(0.8)) deviation / effect)^2`, rounded up, at least 2.
///
/// `deviation` is that of the differences. The law is taken for normal. `None` where no number of seeds does: an effect that is not
/// positive.
pub fn seeds_to_show(effect: f64, deviation: f64) -> Option<usize> {
    let ratio = (normal_quantile(0.975) + normal_quantile(0.8)) * deviation / effect;
    (effect > 0.0).then(|| ((ratio * ratio).ceil() as usize).max(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::statistics::Mean;
    use vantage_dataset::Seed;

    #[test]
    fn numbers_are_those_of_the_formula() {
        // 7.849 (sd / effect)^2
        assert_eq!(seeds_to_show(0.5, 1.0), Some(32));
        assert_eq!(seeds_to_show(0.0125, 0.127), Some(811));
        assert_eq!((seeds_to_show(1.0, 0.0), seeds_to_show(1.0, 0.1)), (Some(2), Some(2)));
        assert_eq!((seeds_to_show(0.0, 1.0), seeds_to_show(-1.0, 1.0)), (None, None));
    }

    #[test]
    fn as_many_seeds_show_it_four_times_in_five() {
        let mut stream = Seed(5).stream("power", 0);
        let n = seeds_to_show(0.5, 1.0).unwrap();
        let shown = (0..4000)
            .filter(|_| {
                let values: Vec<f64> = (0..n).map(|_| 0.5 + stream.normal()).collect();
                Mean::of(&values).unwrap().interval().unwrap().0 > 0.0
            })
            .count();
        assert!((shown as f64 / 4000.0 - 0.8).abs() < 0.03, "{shown} of 4000");
    }
}
