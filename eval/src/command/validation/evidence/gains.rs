//! What a discrepancy of the azimuth gains, by its deviation and smoothness: what fits it.

use super::{Alone, TrueViews, ViewNoise};
use garde::Validate;
use rayon::prelude::*;
use vantage_model::ObservationModel;
use vantage_slam::AzimuthDiscrepancy;
use vantage_slam::discrepancy::Discrepant;

const SIGMAS_DEG: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0];
/// Concentrations of smooth errors that are tried.
pub const CONCENTRATIONS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// What errors of the azimuth of one deviation gain over none, nats a view; minus infinity where the model gives no finite answer.
pub struct Gains {
    /// The deviation, degrees.
    pub sigma_deg: f64,
    /// Of errors that each view draws anew: the covariance of a view's residual grows along the derivative by the azimuth.
    pub white: f64,
    /// Of [smooth ones](Discrepant), by concentration.
    pub smooth: [f64; CONCENTRATIONS.len()],
}

impl Gains {
    /// Those of a grid of deviations; `None` where the model has no finite answer without an error.
    pub fn of(objects: &[TrueViews], model: &dyn ObservationModel) -> Option<Vec<Self>> {
        let views: usize = objects.iter().map(TrueViews::len).sum();
        let sum = |model: &dyn ObservationModel, white: f64| -> Option<f64> {
            let noise = ViewNoise { white, ..ViewNoise::NONE };
            objects.par_iter().map(|object| Some(object.evidence(&Alone(model), noise)?.value)).sum()
        };
        let none = sum(model, 0.0)?;
        let gain = |evidence: Option<f64>| {
            evidence.map_or(f64::NEG_INFINITY, |evidence| (evidence - none) / views as f64)
        };
        let of_sigma = |sigma_deg: f64| {
            let sigma = sigma_deg.to_radians();
            let smooth = CONCENTRATIONS.map(|concentration| {
                gain(sum(&Discrepant::new(model, &AzimuthDiscrepancy { sigma, concentration }), 0.0))
            });
            Self { sigma_deg, white: gain(sum(model, sigma)), smooth }
        };
        Some(SIGMAS_DEG.map(of_sigma).into())
    }

    /// The smooth error that gains most of those that an estimator takes, and how much; `None` where none is defined.
    pub fn most(all: &[Self]) -> Option<(AzimuthDiscrepancy, f64)> {
        let each = all.iter().flat_map(|gains| {
            let sigma = gains.sigma_deg.to_radians();
            let of = move |(&concentration, &gain)| (AzimuthDiscrepancy { sigma, concentration }, gain);
            CONCENTRATIONS.iter().zip(&gains.smooth).map(of)
        });
        each.filter(|(of, gain)| gain.is_finite() && of.validate().is_ok()).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}
