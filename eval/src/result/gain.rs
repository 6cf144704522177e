//! A gain: what paired differences to the reference say of a method, made for skewed ones.

use super::better::Better;
use super::bootstrap::bca_interval;
use super::paired::Paired;
use super::power::seeds_to_show;
use super::statistics::Mean;

/// Seeds that the share of the best is of, and how many there have to be.
const BEST: usize = 5;
const FEWEST: usize = 10;
/// The difference that the number of seeds is told for, over the reference's mean.
const SHOWN: f64 = 0.05;

/// Of a method's score less the reference's on the same seed, in the score's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    /// Number of differences.
    pub seeds: usize,
    /// Their mean, with Student's interval.
    pub mean: Mean,
    /// The 95% BCa interval of the mean; `None` for one seed.
    pub interval: Option<(f64, f64)>,
    /// Their median.
    pub median: f64,
    /// On how many seeds the method is better.
    pub better: usize,
    /// Whether the seeds agree with the sign of the mean: [`Paired::seeds_agree`].
    pub seeds_agree: bool,
    /// Of Wilcoxon's signed ranks, two-sided; `None` where all differences are zero.
    pub p: Option<f64>,
    /// Sum of the five largest gains over that of all differences, above 1 where the others lose; `None` for fewer than ten seeds, or
    /// where the mean is no gain.
    pub best_share: Option<f64>,
    /// Ratio of the method's geometric mean to the reference's, less 1; `None` where a score is not positive.
    pub geometric_change: Option<f64>,
    /// Seeds that would show a difference of 5% of the reference's mean: [`seeds_to_show`]; `None` for one seed, or where that mean is
    /// not positive.
    pub seeds_for_5_percent: Option<usize>,
}

impl Gain {
    /// `None` of a score that has a target, which is better neither higher nor lower.
    pub fn of(paired: &Paired) -> Option<Self> {
        let improvement = match paired.metric().better() {
            Better::Lower => -1.0,
            Better::Higher => 1.0,
            Better::Near(_) => return None,
        };
        let differences = paired.differences();
        let mean = paired.mean()?;
        let deviation = mean.deviation;
        Some(Self {
            seeds: paired.seeds(),
            mean,
            interval: bca_interval(&differences),
            median: paired.median()?,
            better: paired.better(),
            seeds_agree: paired.seeds_agree(),
            p: paired.p(),
            best_share: best_share(differences.iter().map(|d| d * improvement).collect()),
            geometric_change: geometric_change(paired),
            seeds_for_5_percent: deviation
                .and_then(|deviation| seeds_to_show(SHOWN * paired.reference_mean()?, deviation)),
        })
    }
}

fn best_share(mut improvements: Vec<f64>) -> Option<f64> {
    improvements.sort_by(|a, b| b.total_cmp(a));
    let total: f64 = improvements.iter().sum();
    (improvements.len() >= FEWEST && total > 0.0).then(|| improvements[..BEST].iter().sum::<f64>() / total)
}

fn geometric_change(paired: &Paired) -> Option<f64> {
    let positive = paired.scores().iter().all(|(own, reference)| *own > 0.0 && *reference > 0.0);
    let ratio = |(own, reference): &(f64, f64)| libm::log(own / reference);
    let logarithms: f64 = paired.scores().iter().map(ratio).sum();
    positive.then(|| libm::expm1(logarithms / paired.seeds() as f64))
}

#[cfg(test)]
mod tests {
    use super::super::metric::Metric;
    use super::super::table::tests::run;
    use super::*;
    use approx::assert_relative_eq;

    fn paired(metric: Metric, scores: &[(f64, f64)]) -> Paired {
        let runs = |pick: fn(&(f64, f64)) -> f64| {
            let score = |(seed, scores)| run("a", seed as u64, &[(metric, pick(scores))]);
            scores.iter().enumerate().map(score).collect::<Vec<_>>()
        };
        Paired::of(metric, &runs(|scores| scores.0), &runs(|scores| scores.1)).unwrap()
    }

    /// Twelve seeds: the reference is always 1, six large gains, four small, two losses; their sum is -2.
    fn twelve() -> Vec<(f64, f64)> {
        let differences = [-0.5, -0.4, -0.3, -0.3, -0.2, -0.2, -0.1, -0.05, -0.03, -0.02, 0.04, 0.06]
            .map(|d| (1.0 + d, 1.0));
        differences.to_vec()
    }

    #[test]
    fn all_is_told_of_differences() {
        let gain = Gain::of(&paired(Metric::Ate, &twelve())).unwrap();
        assert_eq!((gain.seeds, gain.better), (12, 10));
        assert_relative_eq!(gain.mean.mean, -2.0 / 12.0, epsilon = 1e-12);
        assert_relative_eq!(gain.median, -0.15, epsilon = 1e-12);
        assert_relative_eq!(gain.best_share.unwrap(), 1.7 / 2.0, epsilon = 1e-12);
        let logarithms: f64 = twelve().iter().map(|(own, _)| own.ln()).sum();
        assert_relative_eq!(gain.geometric_change.unwrap(), (logarithms / 12.0).exp() - 1.0, epsilon = 1e-12);
        let deviation = gain.mean.deviation.unwrap();
        assert_eq!(gain.seeds_for_5_percent, Some((7.8489 * (deviation / 0.05).powi(2)).ceil() as usize));
        let (low, high) = gain.interval.unwrap();
        assert!(low < gain.mean.mean && gain.mean.mean < high && high < 0.0 && gain.p.unwrap() < 0.02);
    }

    #[test]
    fn a_share_is_of_gains_in_the_direction_of_the_score() {
        let share = |metric, scores: &[(f64, f64)]| Gain::of(&paired(metric, scores)).unwrap().best_share;
        let higher: Vec<(f64, f64)> =
            twelve().iter().map(|(own, reference)| (2.0 - own, *reference)).collect();
        assert_relative_eq!(share(Metric::Ari, &higher).unwrap(), 1.7 / 2.0, epsilon = 1e-12);
        assert_eq!((share(Metric::Ate, &higher), share(Metric::Ate, &twelve()[..9])), (None, None));
        assert_eq!(Gain::of(&paired(Metric::NeesPose, &twelve())), None);
    }

    #[test]
    fn what_is_undefined_is_none() {
        let one = Gain::of(&paired(Metric::Ate, &twelve()[..1])).unwrap();
        assert_eq!((one.interval, one.seeds_for_5_percent, one.p), (None, None, Some(1.0)));
        let same = Gain::of(&paired(Metric::Ate, &[(0.5, 0.5), (0.7, 0.7)])).unwrap();
        assert_eq!((same.p, same.interval, same.geometric_change), (None, Some((0.0, 0.0)), Some(0.0)));
        let zero = Gain::of(&paired(Metric::Ate, &[(0.0, 0.0), (0.7, 0.0)])).unwrap();
        assert_eq!((zero.geometric_change, zero.seeds_for_5_percent), (None, None));
    }
}
