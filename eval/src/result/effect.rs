//! What differences show: the rule of the sentence below a scene's tables and of the table of scenes.

use super::gain::Gain;
use super::holm::SIGNIFICANT;

/// Of a method on the mean of a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// It lowers it.
    Lowers,
    /// It raises it.
    Raises,
    /// Neither is certain.
    Undecided,
}

impl Effect {
    /// It is told where the interval and `p` are [certain](is_certain), and the seeds agree; `p` is adjusted over all that is told.
    pub fn of(gain: &Gain, p: Option<f64>) -> Self {
        match gain.interval.filter(|_| gain.seeds_agree && is_certain(gain.interval, p)) {
            Some((_, high)) if high < 0.0 => Effect::Lowers,
            Some(_) => Effect::Raises,
            None => Effect::Undecided,
        }
    }
}

/// Whether the interval of a mean leaves out 0, and `p`, adjusted over all that is told, is below 0.05.
///
/// Ranks and mean have to agree: of skewed differences they may not.
pub fn is_certain(interval: Option<(f64, f64)>, p: Option<f64>) -> bool {
    p.is_some_and(|p| p < SIGNIFICANT) && interval.is_some_and(|(low, high)| low > 0.0 || high < 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::metric::Metric;
    use super::super::paired::Paired;
    use super::super::table::tests::run;
    use super::*;

    /// Of an error that differs by so much from one of 1.
    fn gain(differences: &[f64]) -> Gain {
        let runs = |ate: &dyn Fn(f64) -> f64| {
            let run = |(seed, by): (usize, &f64)| run("a", seed as u64, &[(Metric::Ate, ate(*by))]);
            differences.iter().enumerate().map(run).collect::<Vec<_>>()
        };
        Gain::of(&Paired::of(Metric::Ate, &runs(&|by| 1.0 + by), &runs(&|_| 1.0)).unwrap()).unwrap()
    }

    #[test]
    fn an_effect_is_told_where_interval_signs_and_p_agree() {
        let gains: Vec<f64> = (0..20).map(|i| -0.01 * f64::from(i) - 0.01).collect();
        let harms: Vec<f64> = gains.iter().map(|d| -d).collect();
        assert_eq!(Effect::of(&gain(&gains), Some(0.01)), Effect::Lowers);
        assert_eq!(Effect::of(&gain(&harms), Some(0.01)), Effect::Raises);
        assert_eq!(Effect::of(&gain(&gains), Some(0.06)), Effect::Undecided);
        assert_eq!(Effect::of(&gain(&gains), None), Effect::Undecided);
        // A few large gains and many small losses: the interval tells of a gain, the signs do not.
        let few: Vec<f64> = (0..20).map(|i| if i < 8 { -1.0 - 0.1 * f64::from(i) } else { 0.01 }).collect();
        assert!(gain(&few).interval.unwrap().1 < 0.0);
        assert_eq!(Effect::of(&gain(&few), Some(0.01)), Effect::Undecided);
        let zero: Vec<f64> = gains.iter().map(|d| if *d < -0.19 { 2.5 } else { *d }).collect();
        assert_eq!(Effect::of(&gain(&zero), Some(0.01)), Effect::Undecided, "the interval holds 0");
        let even: Vec<f64> = (0..20).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        assert_eq!(Effect::of(&gain(&even), Some(0.01)), Effect::Undecided);
    }
}
