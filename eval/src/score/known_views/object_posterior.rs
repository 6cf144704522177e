//! What a few views from known viewpoints say of an object's latent, and what that says of another view.

use super::finite;
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{AnswerError, LatentGaussian, ObservationModel, student_t};

/// Most steps of Gauss and Newton, and halvings of one.
const STEPS: usize = 20;
const HALVINGS: usize = 6;
/// A step is the last that changes no number by more.
const CONVERGED: f64 = 1e-3;

/// The Gaussian about the most probable latent, by Laplace's method.
pub struct ObjectPosterior<'m> {
    model: &'m dyn ObservationModel,
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Negative log of the posterior density at the mean, but for a constant.
    cost: f64,
}

/// A view whose crop is measured.
struct Measured<'v> {
    viewpoint: &'v Viewpoint,
    measurement: DVector<f64>,
}

impl<'m> ObjectPosterior<'m> {
    /// Of these views, whose viewpoints are in one frame; the descent begins where the encoder's factors lead. `None` where the
    /// model has no answer.
    pub fn new(
        model: &'m dyn ObservationModel,
        views: &[(&Crop, Viewpoint)],
    ) -> Result<Option<Self>, AnswerError> {
        let (latent, views) = (begin(model, views)?, measured(model, views)?);
        Ok(descend(model, latent, &views))
    }

    /// Negative log of the posterior at the encoder's latent, but for a constant: how well views agree with a frame.
    pub fn first_cost(
        model: &dyn ObservationModel,
        views: &[(&Crop, Viewpoint)],
    ) -> Result<Option<f64>, AnswerError> {
        Ok(cost(model, &begin(model, views)?, &measured(model, views)?))
    }

    /// Negative log of the posterior density at the mean, but for a constant.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// `R (m - m(e, x))` at the most probable latent, `[M]`; `None` where the model has no answer.
    pub fn whitened_residual(
        &self,
        measurement: &DVector<f64>,
        viewpoint: &Viewpoint,
    ) -> Option<DVector<f64>> {
        let predicted = self.model.predict(&self.mean, viewpoint).ok()?;
        Some(self.model.noise().sqrt_information() * (measurement - predicted))
    }

    /// `log p(m | views, viewpoint)`, nats, but for a constant: the Student t of the model's noise, its covariance that of the noise and
    /// of the prediction. `None` where the model has no answer.
    pub fn log_density(&self, measurement: &DVector<f64>, viewpoint: &Viewpoint) -> Option<f64> {
        let at = self.model.linearize(&self.mean, viewpoint).ok()?;
        let (whitening, nu) =
            (self.model.noise().sqrt_information(), self.model.noise().degrees_of_freedom());
        let residual = whitening * (measurement - at.mean);
        let rows = whitening * at.d_latent;
        let spread = (&rows * &self.covariance) * rows.transpose();
        let covariance = spread + DMatrix::identity(residual.len(), residual.len());
        let root = covariance.cholesky()?;
        let squared = root.l_dirty().solve_lower_triangular(&residual)?.norm_squared();
        let log_det: f64 = root.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum();
        let density = -student_t::loss(squared, residual.len(), nu) - log_det;
        density.is_finite().then_some(density)
    }
}

fn begin(model: &dyn ObservationModel, views: &[(&Crop, Viewpoint)]) -> Result<DVector<f64>, AnswerError> {
    let mut factors = Vec::with_capacity(views.len());
    for (crop, viewpoint) in views {
        factors.extend(finite(model.encode(crop, viewpoint))?);
    }
    Ok(LatentGaussian::posterior(model.latent_dim(), &factors).mean)
}

fn measured<'v>(
    model: &dyn ObservationModel,
    views: &'v [(&Crop, Viewpoint)],
) -> Result<Vec<Measured<'v>>, AnswerError> {
    let mut all = Vec::with_capacity(views.len());
    for (crop, viewpoint) in views {
        let measurement = finite(model.measure(crop))?;
        all.extend(measurement.map(|measurement| Measured { viewpoint, measurement }));
    }
    Ok(all)
}

fn cost(model: &dyn ObservationModel, latent: &DVector<f64>, views: &[Measured<'_>]) -> Option<f64> {
    let noise = model.noise();
    let mut sum = latent.norm_squared() / 2.0;
    for view in views {
        let predicted = model.predict(latent, view.viewpoint).ok()?;
        let squared = (noise.sqrt_information() * (&view.measurement - predicted)).norm_squared();
        sum += student_t::loss(squared, view.measurement.len(), noise.degrees_of_freedom());
    }
    sum.is_finite().then_some(sum)
}

fn descend<'m>(
    model: &'m dyn ObservationModel,
    mut latent: DVector<f64>,
    views: &[Measured<'_>],
) -> Option<ObjectPosterior<'m>> {
    let (whitening, nu) = (model.noise().sqrt_information(), model.noise().degrees_of_freedom());
    let dim = latent.len();
    let mut current = cost(model, &latent, views)?;
    for step in 1.. {
        let (mut precision, mut gradient) = (DMatrix::identity(dim, dim), latent.clone());
        for view in views {
            let at = model.linearize(&latent, view.viewpoint).ok()?;
            let (rows, residual) = (whitening * at.d_latent, whitening * (at.mean - &view.measurement));
            let weight = student_t::weight(residual.norm_squared(), residual.len(), nu);
            precision.gemm_tr(weight, &rows, &rows, 1.0);
            gradient.gemv_tr(weight, &rows, &residual, 1.0);
        }
        let root = precision.cholesky()?;
        let mut change = -root.solve(&gradient);
        let better = (0..HALVINGS).find_map(|_| {
            let moved = &latent + &change;
            let reached = cost(model, &moved, views).filter(|&reached| reached <= current);
            let size = change.amax();
            change /= 2.0;
            Some((moved, reached?, size))
        });
        let last = step == STEPS || better.as_ref().is_none_or(|(_, _, size)| *size < CONVERGED);
        if last {
            return Some(ObjectPosterior { model, mean: latent, covariance: root.inverse(), cost: current });
        }
        (latent, current, _) = better?;
    }
    None
}
