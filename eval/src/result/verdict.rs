//! What is told of a gain: the one rule of the sentence below a scene's tables and of the table of scenes.

use super::gain::Gain;
use super::holm::SIGNIFICANT;
use std::fmt;

/// Of an error, which is better lower.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is lower.
    Gain,
    /// It is higher.
    Harm,
    /// Neither is certain.
    Undecided,
}

impl Verdict {
    /// A gain or a harm is told where the BCa interval leaves out 0, the seeds agree, and Wilcoxon's `p`, adjusted over all that is told, is below 0.05.
    pub fn of(gain: &Gain, p: Option<f64>) -> Self {
        let agrees = gain.seeds_agree && p.is_some_and(|p| p < SIGNIFICANT);
        match gain.interval.filter(|_| agrees) {
            Some((_, high)) if high < 0.0 => Verdict::Gain,
            Some((low, _)) if low > 0.0 => Verdict::Harm,
            _ => Verdict::Undecided,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Gain => "gain",
            Verdict::Harm => "harm",
            Verdict::Undecided => "undecided",
        })
    }
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
    fn a_gain_is_told_where_interval_signs_and_p_agree() {
        let gains: Vec<f64> = (0..20).map(|i| -0.01 * f64::from(i) - 0.01).collect();
        let harms: Vec<f64> = gains.iter().map(|d| -d).collect();
        assert_eq!(Verdict::of(&gain(&gains), Some(0.01)), Verdict::Gain);
        assert_eq!(Verdict::of(&gain(&harms), Some(0.01)), Verdict::Harm);
        assert_eq!(Verdict::of(&gain(&gains), Some(0.06)), Verdict::Undecided);
        assert_eq!(Verdict::of(&gain(&gains), None), Verdict::Undecided);
        // A few large gains and many small losses: the interval tells of a gain, the signs do not.
        let few: Vec<f64> = (0..20).map(|i| if i < 8 { -1.0 - 0.1 * f64::from(i) } else { 0.01 }).collect();
        assert!(gain(&few).interval.unwrap().1 < 0.0);
        assert_eq!(Verdict::of(&gain(&few), Some(0.01)), Verdict::Undecided);
        let even: Vec<f64> = (0..20).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        assert_eq!(Verdict::of(&gain(&even), Some(0.01)), Verdict::Undecided);
    }
}
