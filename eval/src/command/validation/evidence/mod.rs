//! How probable validation crops are at their true viewpoints, by a model and what is assumed of its errors.

mod gains;
mod pair_gains;
mod scale_gains;
mod visit_gains;

pub use gains::{CONCENTRATIONS, Gains};
pub use pair_gains::{PAIRINGS, pair_gains};
pub use scale_gains::{SCALE_SPREADS, ScaleGains};
pub use visit_gains::VisitGains;

use super::Trial;
use crate::pipeline::true_viewpoint;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use vantage_dataset::Viewpoint;
use vantage_model::{Information, Linearization, MeasurementNoise, ObservationModel, student_t};

/// Steps of Gauss-Newton to the most probable latent.
const ITERATIONS: usize = 8;

/// The views of one object.
pub struct TrueViews {
    views: Vec<TrueView>,
    /// The mean latent that the encoder reads from all of them.
    encoded: DVector<f64>,
}

/// A view from a true viewpoint.
struct TrueView {
    step: usize,
    measurement: DVector<f64>,
    viewpoint: Viewpoint,
}

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
            let (Ok(measurement), Ok(encoded)) = (model.measure(crop), model.encode(crop, &viewpoint)) else {
                continue;
            };
            views.push(TrueView { step: detection.step, measurement, viewpoint });
            read.push(encoded);
        }
        let Information { precision, weighted_mean } = Information::of(model.latent_dim(), &read);
        (!views.is_empty()).then(|| Self { views, encoded: weighted_mean.component_div(&precision) })
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.views.len()
    }

    /// `log P(m(z_1) .. m(z_n) | x_1 .. x_n)` by Laplace, nats up to a constant of the measurement's length; `None` where the model gives no
    /// finite answer.
    fn evidence(&self, predicted: &dyn Predicted, noise: ViewNoise) -> Option<Evidence> {
        let precision = predicted.prior_precision(self);
        let start = self.encoded.clone().resize_vertically(precision.len(), 0.0);
        self.evidence_from(start, &precision, predicted, noise)
    }

    /// The same, searched for from a latent.
    fn evidence_from(
        &self,
        mut latent: DVector<f64>,
        precision: &DVector<f64>,
        predicted: &dyn Predicted,
        noise: ViewNoise,
    ) -> Option<Evidence> {
        let mut near = self.near(predicted, precision, noise, &latent)?;
        for _ in 0..ITERATIONS {
            let step = near.hessian.solve(&near.gradient);
            let shorter = [1.0, 0.5, 0.25].into_iter().find_map(|share| {
                let moved = &latent - &step * share;
                let there = self.near(predicted, precision, noise, &moved)?;
                (there.cost < near.cost).then_some((moved, there))
            });
            let Some((moved, there)) = shorter else { break };
            let is_settled = near.cost - there.cost < SETTLED;
            (latent, near) = (moved, there);
            if is_settled {
                break;
            }
        }
        let half_log_det: f64 = near.hessian.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum();
        let of_prior: f64 = precision.iter().map(|x| libm::log(*x)).sum::<f64>() / 2.0;
        Some(Evidence { value: of_prior - near.cost - half_log_det, latent, hessian: near.hessian })
    }

    fn near(
        &self,
        predicted: &dyn Predicted,
        precision: &DVector<f64>,
        noise: ViewNoise,
        latent: &DVector<f64>,
    ) -> Option<Near> {
        let ViewNoise { white, scale } = noise;
        let mut hessian = DMatrix::from_diagonal(precision);
        let mut gradient = latent.component_mul(precision);
        let mut cost = latent.dot(&gradient) / 2.0;
        for (index, TrueView { measurement, viewpoint, .. }) in self.views.iter().enumerate() {
            let (Linearization { mean, d_latent, d_viewpoint }, of) = predicted.at(self, index, latent)?;
            let (whiten, nu) = (of.sqrt_information() / scale, of.degrees_of_freedom());
            let mut residual = &whiten * (measurement - mean);
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
            cost += student_t::loss(s, residual.len(), nu) + residual.len() as f64 * libm::log(scale)
                - of.log_normalizer();
            hessian.gemm_tr(weight, &jacobian, &jacobian, 1.0);
            gradient.gemv_tr(weight, &jacobian, &residual, 1.0);
        }
        Some(Near { cost, gradient, hessian: hessian.cholesky()? })
    }
}

/// A decrease of the negative log-posterior that is none, nats.
const SETTLED: f64 = 1e-6;

/// What is expected of an object's views by a latent.
trait Predicted: Sync {
    /// Of the latent's independent numbers, one over their variances beforehand.
    fn prior_precision(&self, object: &TrueViews) -> DVector<f64>;

    /// The view of an index near a latent, with derivatives by that and by its viewpoint, and the noise about it.
    fn at(
        &self,
        object: &TrueViews,
        index: usize,
        latent: &DVector<f64>,
    ) -> Option<(Linearization, &MeasurementNoise)>;
}

/// Each view by the latent alone.
struct Alone<'m>(&'m dyn ObservationModel);

impl Predicted for Alone<'_> {
    fn prior_precision(&self, _: &TrueViews) -> DVector<f64> {
        DVector::from_element(self.0.latent_dim(), 1.0)
    }

    fn at(
        &self,
        object: &TrueViews,
        index: usize,
        latent: &DVector<f64>,
    ) -> Option<(Linearization, &MeasurementNoise)> {
        Some((self.0.linearize(latent, &object.views[index].viewpoint).ok()?, self.0.noise()))
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

/// Of the views of an object.
struct Evidence {
    /// Its logarithm, nats.
    value: f64,
    /// The most probable latent, and the Hessian there.
    latent: DVector<f64>,
    hessian: Cholesky<f64, Dyn>,
}

/// The negative log-posterior of a latent, its gradient, and its Hessian by Gauss and Newton.
struct Near {
    cost: f64,
    gradient: DVector<f64>,
    hessian: Cholesky<f64, Dyn>,
}
