//! What the decoder says of views it has not seen: azimuths, residuals, images.
//!
//! The latent of each instance is fused from the views of its even sessions; its views of odd sessions, under other
//! light, are the queries.

use super::azimuth_information::promised_deviation;
use super::bound::divergence;
use super::calibration::{REGIONS, calibration};
use super::embedding::Scores;
use super::likelihood::Likelihood;
use super::psnr::{mean_crop, psnr};
use super::viewpoint::{ViewpointTrial, most_likely_azimuth, summarize};
use crate::result::metric::Metric;
use crate::result::statistics::quantile;
use nalgebra::DVector;
use std::f64::consts::PI;
use vantage_dataset::{Crop, Symmetry, View, ViewSet};
use vantage_learn::Viewing;
use vantage_model::{AnswerError, LatentGaussian};

/// Offsets of the mean likelihood from the true azimuth.
const OFFSETS: usize = 72;
/// Deviations of a Gaussian that hold 95% of it.
const WITHIN: f64 = 1.959_963_984_540_054;

/// All that was said.
#[derive(Default)]
pub struct Decoded {
    /// Scores of the model.
    pub model: Scores,
    /// Scores of the mean of the known views.
    pub mean_view: Scores,
    /// See [`Unseen`](super::unseen::Unseen).
    pub trials: Vec<ViewpointTrial>,
    /// See [`Unseen`](super::unseen::Unseen).
    pub likelihood: Vec<(f64, f64)>,
}

/// Decodes all queries of a set; `factors` are the encoder's, one a view.
pub fn decode(
    set: &ViewSet,
    factors: &[LatentGaussian],
    model: &dyn Viewing,
) -> Result<Decoded, AnswerError> {
    let dimension = model.latent().dimension;
    let mut found = Queries::default();
    for (index, instance) in set.instances.iter().enumerate() {
        let own = || set.views.iter().zip(factors).filter(move |(view, _)| view.instance == index);
        let known = || own().filter(|(view, _)| view.session % 2 == 0);
        let seen: Vec<LatentGaussian> = known().map(|(_, factor)| factor.clone()).collect();
        let latent = LatentGaussian::posterior(dimension, &seen).mean;
        let mean_view = mean_crop(known().map(|(view, _)| &view.crop));
        for (number, (view, factor)) in own().filter(|(view, _)| view.session % 2 == 1).enumerate() {
            let likelihood = Likelihood::new(model, &latent, &view.crop)?;
            let azimuth = view.viewpoint.azimuth();
            let at = |turn: f64| likelihood.at(&view.viewpoint.turned(turn));
            let (family, symmetry) = (instance.family.clone(), instance.symmetry);
            let answer = most_likely_azimuth(|candidate| at(candidate - azimuth).unwrap_or(f64::NAN));
            let trial = ViewpointTrial { family, symmetry, azimuth, found: answer };
            found.promise(&trial, &likelihood, view, model);
            if number == 0 {
                found.by_image.extend(by_image(view, &latent, model, &trial));
            }
            found.trials.push(trial);
            if symmetry == Symmetry::None {
                found.curve(at);
            }
            found.residuals.extend(likelihood.whitened_residual(&view.viewpoint));
            found.log_likelihoods.extend(likelihood.log_density(&view.viewpoint));
            let single = LatentGaussian::posterior(dimension, std::slice::from_ref(factor));
            found.divergences.push(divergence(&single));
            found.own.extend(against(view, &single.mean, model)?);
            found.held_out.extend(against(view, &latent, model)?);
            found.mean_view.extend(mean_view.as_ref().map(|mean| psnr(&view.crop, mean)));
        }
    }
    Ok(found.decoded(model))
}

/// PSNR of what a latent looks like from a view's viewpoint, by a model that can tell.
fn against(view: &View, latent: &DVector<f64>, model: &dyn Viewing) -> Result<Option<f64>, AnswerError> {
    let predicted: Option<Crop> = model.reconstruct(latent, &view.viewpoint).transpose()?;
    Ok(predicted.map(|predicted| psnr(&view.crop, &predicted)))
}

/// The trial with the azimuth from which the latent looks most like the crop, pixel by pixel; `None` of a surface of revolution,
/// and of a model that cannot tell.
fn by_image(
    view: &View,
    latent: &DVector<f64>,
    model: &dyn Viewing,
    trial: &ViewpointTrial,
) -> Option<ViewpointTrial> {
    trial.error()?;
    let likeness = |turn: f64| {
        let predicted = model.reconstruct(latent, &view.viewpoint.turned(turn))?.ok()?;
        Some(psnr(&view.crop, &predicted))
    };
    likeness(0.0)?;
    let found = most_likely_azimuth(|azimuth| likeness(azimuth - trial.azimuth).unwrap_or(f64::NAN));
    Some(ViewpointTrial { found, ..trial.clone() })
}

#[derive(Default)]
struct Queries {
    trials: Vec<ViewpointTrial>,
    by_image: Vec<ViewpointTrial>,
    log_likelihoods: Vec<f64>,
    divergences: Vec<f64>,
    /// Promised deviations, radians, and whether the error was within 1.96 of them.
    promised: Vec<(f64, bool)>,
    /// Sum of the curves, and how many.
    curve: (Vec<f64>, usize),
    residuals: Vec<DVector<f64>>,
    own: Vec<f64>,
    held_out: Vec<f64>,
    mean_view: Vec<f64>,
}

impl Queries {
    /// Surfaces of revolution have no azimuth to promise.
    fn promise(
        &mut self,
        trial: &ViewpointTrial,
        likelihood: &Likelihood<'_>,
        view: &View,
        model: &dyn Viewing,
    ) {
        let Some(error) = trial.error() else { return };
        let Some((derivative, sqrt_information)) = likelihood.by_azimuth(&view.viewpoint) else { return };
        let degrees = model.noise().degrees_of_freedom();
        let promised = promised_deviation(&derivative, sqrt_information, degrees);
        self.promised.extend(promised.map(|deviation| (deviation, error <= WITHIN * deviation)));
    }

    fn curve(&mut self, at: impl Fn(f64) -> Option<f64>) {
        let values: Option<Vec<f64>> = (0..=OFFSETS).map(|i| at(offset(i))).collect();
        let (Some(values), Some(at_truth)) = (values, at(0.0)) else { return };
        self.curve.0.resize(OFFSETS + 1, 0.0);
        self.curve.0.iter_mut().zip(values).for_each(|(sum, value)| *sum += value - at_truth);
        self.curve.1 += 1;
    }

    fn decoded(mut self, model: &dyn Viewing) -> Decoded {
        let mut scores = Scores::new();
        if let Some(shape) = summarize(&self.trials).model {
            scores.insert(Metric::ViewpointMedian, shape.median);
            scores.insert(Metric::ViewpointRight, shape.right);
        }
        let by_image = summarize(&self.by_image).model;
        scores.extend(by_image.map(|shape| (Metric::ViewpointByImage, shape.median)));
        scores.extend(mean(&self.log_likelihoods).map(|value| (Metric::LogLikelihood, value)));
        scores.extend(mean(&self.divergences).map(|value| (Metric::Divergence, value)));
        self.promised.sort_by(|a, b| a.0.total_cmp(&b.0));
        let deviations: Vec<f64> = self.promised.iter().map(|(deviation, _)| *deviation).collect();
        if let Some(median) = quantile(&deviations, 0.5) {
            let inside = self.promised.iter().filter(|(_, inside)| *inside).count();
            scores.insert(Metric::ViewpointPromised, median);
            scores.insert(Metric::ViewpointInside, inside as f64 / deviations.len() as f64);
        }
        scores.extend(mean(&self.own).map(|value| (Metric::Psnr, value)));
        scores.extend(mean(&self.held_out).map(|value| (Metric::PsnrHeldOut, value)));
        scores.extend(calibration_scores(&self.residuals, model.noise().degrees_of_freedom()));
        let (sums, curves) = self.curve;
        let point = |(i, sum): (usize, f64)| (offset(i), sum / curves as f64);
        Decoded {
            model: scores,
            mean_view: mean(&self.mean_view).map(|value| (Metric::PsnrHeldOut, value)).into_iter().collect(),
            trials: self.trials,
            likelihood: sums.into_iter().enumerate().map(point).collect(),
        }
    }
}

fn offset(i: usize) -> f64 {
    (i as f64 / OFFSETS as f64 * 2.0 - 1.0) * PI
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn calibration_scores(residuals: &[DVector<f64>], degrees_of_freedom: f64) -> Scores {
    let Some(found) = calibration(residuals, degrees_of_freedom) else { return Scores::new() };
    let mut scores = Scores::from([
        (Metric::Inside50, found.inside[0]),
        (Metric::Inside80, found.inside[1]),
        (Metric::Inside95, found.inside[2]),
    ]);
    if let Some([half, _, most]) = found.gaussian_inside {
        scores.extend([(Metric::GaussianInside50, half), (Metric::GaussianInside95, most)]);
    }
    let number_inside: Vec<f64> = found.number_inside.iter().map(|&[_, _, most]| most).collect();
    scores.extend(mean(&number_inside).map(|share| (Metric::NumberInside95, share)));
    let farthest = |a: &&f64, b: &&f64| (*a - REGIONS[2]).abs().total_cmp(&(*b - REGIONS[2]).abs());
    let worst = number_inside.iter().max_by(farthest);
    scores.extend(worst.map(|&share| (Metric::WorstNumberInside95, share)));
    scores.extend(found.squared_norm_variance.map(|ratio| (Metric::SquaredNormVariance, ratio)));
    scores
}
