//! What factors on the noise of crops gain.

use super::{Alone, TrueViews, ViewNoise};
use rayon::prelude::*;
use vantage_model::ObservationModel;

/// Deviations that are tried of the logarithm of a factor by which each object multiplies the noise of its views.
pub const SCALE_SPREADS: [f64; 4] = [0.1, 0.2, 0.3, 0.5];
/// Steps of the logarithm of such a factor, to either side of none, and their length: about two deviations of what the views of an object
/// leave of it, so that sums over them are integrals to a tenth of a nat.
const SCALE_STEPS: i32 = 12;
const SCALE_STEP: f64 = 0.1;

/// What factors on the noise of views gain over none, nats a view.
pub struct ScaleGains {
    /// Of those that are one for all objects, the factor that gains most, and its gain.
    pub common: (f64, f64),
    /// Of a factor of each object's own, log-normal about that, by its [spread](SCALE_SPREADS).
    pub own: [f64; SCALE_SPREADS.len()],
}

impl ScaleGains {
    /// `None` where the model has no finite answer.
    pub fn of(objects: &[TrueViews], model: &dyn ObservationModel) -> Option<Self> {
        let views: usize = objects.iter().map(TrueViews::len).sum();
        let steps = || -SCALE_STEPS..=SCALE_STEPS;
        let log_scale = |step: i32| f64::from(step) * SCALE_STEP;
        let evidences = |object: &TrueViews| -> Option<Vec<f64>> {
            let of = |step| {
                let noise = ViewNoise { scale: libm::exp(log_scale(step)), ..ViewNoise::NONE };
                Some(object.evidence(&Alone(model), noise)?.value)
            };
            steps().map(of).collect()
        };
        let all: Vec<Vec<f64>> = objects.par_iter().map(evidences).collect::<Option<_>>()?;
        let none = SCALE_STEPS as usize;
        let gain = |of: &dyn Fn(&[f64]) -> f64| {
            all.iter().map(|evidences| of(evidences) - evidences[none]).sum::<f64>() / views as f64
        };
        let common = steps().enumerate().map(|(i, step)| (log_scale(step), gain(&|evidences| evidences[i])));
        let (mean, most) = common.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let of_spread = |spread: f64| {
            let prior: Vec<f64> =
                steps().map(|step| -((log_scale(step) - mean) / spread).powi(2) / 2.0).collect();
            gain(&|evidences| {
                let joint: Vec<f64> = evidences.iter().zip(&prior).map(|(a, b)| a + b).collect();
                log_sum_exp(&joint) - log_sum_exp(&prior)
            })
        };
        Some(Self { common: (libm::exp(mean), most), own: SCALE_SPREADS.map(of_spread) })
    }
}

fn log_sum_exp(logs: &[f64]) -> f64 {
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + libm::log(logs.iter().map(|log| libm::exp(log - most)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn logs_of_sums_do_not_overflow() {
        assert_relative_eq!(log_sum_exp(&[1000.0, 1000.0]), 1000.0 + libm::log(2.0), max_relative = 1e-14);
        assert_eq!(log_sum_exp(&[f64::NEG_INFINITY, 3.0]), 3.0);
    }
}
