//! Stage 3: the noise of the measurement, on instances the networks have not seen.

use super::predictions::Predictions;
use crate::residual::{RESIDUALS_PER_DIMENSION, ResidualNoise};
use crate::train::data::views::Views;
use crate::train::error::TrainError;
use crate::train::network::rows::numbers;
use nalgebra::DMatrix;
use vantage_dataset::Seed;

/// How many of a group's views tell its latent.
fn encoded(views: usize, context: usize) -> usize {
    context.min(views / 2)
}

/// Refuses views that would leave too few residuals, before anything is trained.
pub(crate) fn are_enough(views: &Views, context: usize, dimension: usize) -> Result<(), TrainError> {
    let got = views.groups.iter().map(|group| group.views.len() - encoded(group.views.len(), context)).sum();
    let expected = RESIDUALS_PER_DIMENSION * dimension;
    if got < expected { Err(TrainError::Calibration { got, dimension, expected }) } else { Ok(()) }
}

/// Fits the noise of `m(z) - m(e, x)`: `e` from some views of an instance, the residuals from its others.
pub(crate) fn calibrated(
    predictions: &Predictions,
    views: &Views,
    context: usize,
    seed: Seed,
) -> Result<ResidualNoise, TrainError> {
    let mut residuals = Vec::new();
    for (index, group) in views.groups.iter().enumerate() {
        let mut order = group.views.clone();
        seed.stream("calibration", index as u64).shuffle(&mut order);
        let (encoded, others) = order.split_at(encoded(order.len(), context));
        let latent = predictions.posterior(encoded[0], encoded).mean;
        let (expected, _) = predictions.decode(&latent, encoded[0], others);
        let measured = numbers(predictions.features.measurement(others, predictions.device));
        residuals.extend(measured.iter().zip(&expected).map(|(m, e)| f64::from(*m) - f64::from(*e)));
    }
    let dimension = predictions.architecture.measurement;
    let got = residuals.len() / dimension;
    let residuals = DMatrix::from_row_iterator(got, dimension, residuals);
    let expected = RESIDUALS_PER_DIMENSION * dimension;
    ResidualNoise::fit(&residuals).ok_or(TrainError::Calibration { got, dimension, expected })
}
