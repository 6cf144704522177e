//! How probable validation crops are at their true viewpoints, by a model and a discrepancy: what fits the discrepancy.

use super::Trial;
use crate::pipeline::true_viewpoint;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use vantage_dataset::Viewpoint;
use vantage_model::{Information, Linearization, ObservationModel, student_t};
use vantage_slam::AzimuthDiscrepancy;
use vantage_slam::discrepancy::Discrepant;

const SIGMAS_DEG: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0];
const CONCENTRATIONS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
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

    /// `log P(m(z_1) .. m(z_n) | x_1 .. x_n)` by Laplace, nats up to a constant of the model; `None` where the model gives no finite answer.
    fn evidence(&self, model: &dyn ObservationModel) -> Option<f64> {
        let mut latent = self.1.clone().resize_vertically(model.latent_dim(), 0.0);
        let mut near = self.near(model, &latent)?;
        for _ in 0..ITERATIONS {
            let step = near.hessian.solve(&near.gradient);
            let shorter = [1.0, 0.5, 0.25].into_iter().find_map(|share| {
                let moved = &latent - &step * share;
                let there = self.near(model, &moved)?;
                (there.cost < near.cost).then_some((moved, there))
            });
            let Some((moved, there)) = shorter else { break };
            (latent, near) = (moved, there);
        }
        let half_log_det: f64 = near.hessian.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum();
        Some(-near.cost - half_log_det)
    }

    fn near(&self, model: &dyn ObservationModel, latent: &DVector<f64>) -> Option<Near> {
        let dim = latent.len();
        let (whiten, nu) = (model.noise().sqrt_information(), model.noise().degrees_of_freedom());
        let mut hessian = DMatrix::identity(dim, dim);
        let (mut gradient, mut cost) = (latent.clone(), latent.norm_squared() / 2.0);
        for (measured, viewpoint) in &self.0 {
            let Linearization { mean, d_latent, .. } = model.linearize(latent, viewpoint).ok()?;
            let residual = whiten * (measured - mean);
            let jacobian = -(whiten * d_latent);
            let s = residual.norm_squared();
            let weight = student_t::weight(s, residual.len(), nu);
            cost += student_t::loss(s, residual.len(), nu);
            hessian.gemm_tr(weight, &jacobian, &jacobian, 1.0);
            gradient.gemv_tr(weight, &jacobian, &residual, 1.0);
        }
        Some(Near { cost, gradient, hessian: hessian.cholesky()? })
    }
}

/// The negative log-posterior of a latent, its gradient, and its Hessian by Gauss and Newton.
struct Near {
    cost: f64,
    gradient: DVector<f64>,
    hessian: Cholesky<f64, nalgebra::Dyn>,
}

/// The discrepancy of most evidence among a grid's, and by how many nats a view its evidence is above that of none.
pub fn fit(objects: &[TrueViews], model: &dyn ObservationModel) -> Option<(AzimuthDiscrepancy, f64)> {
    let views: usize = objects.iter().map(TrueViews::len).sum();
    let sum = |model: &dyn ObservationModel| -> Option<f64> {
        objects.par_iter().map(|object| object.evidence(model)).sum()
    };
    let none = sum(model)?;
    let grid = SIGMAS_DEG.into_iter().flat_map(|sigma| {
        let sigma = f64::to_radians(sigma);
        CONCENTRATIONS.map(|concentration| AzimuthDiscrepancy { sigma, concentration })
    });
    let scored = grid.filter_map(|of| Some((of, sum(&Discrepant::new(model, &of))?)));
    let (best, evidence) = scored.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((best, (evidence - none) / views as f64))
}
