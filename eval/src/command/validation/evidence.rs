//! How probable validation crops are at their true viewpoints, by a model and a discrepancy: what fits the discrepancy.

use super::Trial;
use crate::pipeline::true_viewpoint;
use garde::Validate;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use vantage_dataset::Viewpoint;
use vantage_model::{Information, Linearization, ObservationModel, student_t};
use vantage_slam::AzimuthDiscrepancy;
use vantage_slam::discrepancy::Discrepant;

const SIGMAS_DEG: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0];
/// Concentrations of smooth errors that are tried.
pub const CONCENTRATIONS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Deviations that are tried of the logarithm of a factor by which each object multiplies the noise of its views.
pub const SCALE_SPREADS: [f64; 4] = [0.1, 0.2, 0.3, 0.5];
/// Steps of the logarithm of such a factor, to either side of none, and their length: about two deviations of what the views of an object
/// leave of it, so that sums over them are integrals to a tenth of a nat.
const SCALE_STEPS: i32 = 12;
const SCALE_STEP: f64 = 0.1;
/// Steps of Gauss-Newton to the most probable latent.
const ITERATIONS: usize = 8;

/// The views of one object: reduced measurements, what the encoder says of each, true viewpoints.
pub struct TrueViews(Vec<(DVector<f64>, Viewpoint)>, DVector<f64>);

impl TrueViews {
    /// Those of all objects of all trials that have any.
    pub fn of(trials: &[Trial], model: &dyn ObservationModel) -> Vec<Self> {
        let tracks = |trial: &Trial| trial.truth.objects.len();
        let all: Vec<(&Trial, usize)> =
            trials.iter().flat_map(|trial| (0..tracks(trial)).map(move |track| (trial, track))).collect();
        all.par_iter().filter_map(|&(trial, track)| Self::of_object(trial, track, model)).collect()
    }

    fn of_object(
        Trial { observations, truth }: &Trial,
        track: usize,
        model: &dyn ObservationModel,
    ) -> Option<Self> {
        let (mut views, mut read) = (Vec::new(), Vec::new());
        let detections = observations.detections.iter().enumerate();
        for (number, detection) in detections.filter(|(_, detection)| detection.track == track) {
            if detection.bounding_box.is_truncated(&observations.camera) {
                continue;
            }
            let Some((_, viewpoint)) = true_viewpoint(observations, truth, number) else { continue };
            let crop = &detection.masked_crop;
            let (Ok(measured), Ok(encoded)) = (model.measure(crop), model.encode(crop, &viewpoint)) else {
                continue;
            };
            views.push((measured, viewpoint));
            read.push(encoded);
        }
        let Information { precision, weighted_mean } = Information::of(model.latent_dim(), &read);
        (!views.is_empty()).then(|| Self(views, weighted_mean.component_div(&precision)))
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// `log P(m(z_1) .. m(z_n) | x_1 .. x_n)` by Laplace, nats up to a constant of the model, under such noise; `None` where the model gives
    /// no finite answer.
    fn evidence(&self, model: &dyn ObservationModel, noise: ViewNoise) -> Option<f64> {
        let mut latent = self.1.clone().resize_vertically(model.latent_dim(), 0.0);
        let mut near = self.near(model, noise, &latent)?;
        for _ in 0..ITERATIONS {
            let step = near.hessian.solve(&near.gradient);
            let shorter = [1.0, 0.5, 0.25].into_iter().find_map(|share| {
                let moved = &latent - &step * share;
                let there = self.near(model, noise, &moved)?;
                (there.cost < near.cost).then_some((moved, there))
            });
            let Some((moved, there)) = shorter else { break };
            (latent, near) = (moved, there);
        }
        let half_log_det: f64 = near.hessian.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum();
        Some(-near.cost - half_log_det)
    }

    fn near(&self, model: &dyn ObservationModel, noise: ViewNoise, latent: &DVector<f64>) -> Option<Near> {
        let ViewNoise { white, scale } = noise;
        let dim = latent.len();
        let (whiten, nu) = (model.noise().sqrt_information() / scale, model.noise().degrees_of_freedom());
        let mut hessian = DMatrix::identity(dim, dim);
        let (mut gradient, mut cost) = (latent.clone(), latent.norm_squared() / 2.0);
        for (measured, viewpoint) in &self.0 {
            let Linearization { mean, d_latent, d_viewpoint } = model.linearize(latent, viewpoint).ok()?;
            let mut residual = &whiten * (measured - mean);
            let mut jacobian = -(&whiten * d_latent);
            // Whitens by I + g g^T, the derivative of g left out.
            let g = &whiten * d_viewpoint.by_azimuth(viewpoint) * white;
            let stretch = 1.0 + g.norm_squared();
            if stretch > 1.0 {
                let shorter = (1.0 - 1.0 / stretch.sqrt()) / g.norm_squared();
                residual -= &g * (shorter * g.dot(&residual));
                jacobian -= &g * (g.tr_mul(&jacobian) * shorter);
                cost += libm::log(stretch) / 2.0;
            }
            let s = residual.norm_squared();
            let weight = student_t::weight(s, residual.len(), nu);
            cost += student_t::loss(s, residual.len(), nu) + residual.len() as f64 * libm::log(scale);
            hessian.gemm_tr(weight, &jacobian, &jacobian, 1.0);
            gradient.gemv_tr(weight, &jacobian, &residual, 1.0);
        }
        Some(Near { cost, gradient, hessian: hessian.cholesky()? })
    }
}

/// How the noise of views differs from the model's.
#[derive(Clone, Copy)]
struct ViewNoise {
    /// By how much each view's azimuth is off, radians.
    white: f64,
    /// Multiplies the noise.
    scale: f64,
}

impl ViewNoise {
    /// It does not.
    const NONE: Self = Self { white: 0.0, scale: 1.0 };
}

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
                object.evidence(model, ViewNoise { scale: libm::exp(log_scale(step)), ..ViewNoise::NONE })
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

/// The negative log-posterior of a latent, its gradient, and its Hessian by Gauss and Newton.
struct Near {
    cost: f64,
    gradient: DVector<f64>,
    hessian: Cholesky<f64, nalgebra::Dyn>,
}

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
            objects.par_iter().map(|object| object.evidence(model, noise)).sum()
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
