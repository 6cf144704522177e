//! Likeness by a model: the encoder tells which object it is, the decoder from which side it is seen.
//!
//! ```text
//! p(crops of S | one object) = 1/K sum_yaw  [ integral N(e; 0, I) prod_i N(mu_i; e, v_i) de ]^a  [ prod_i p(m(z_i) | mu, x_i) ]^b      i in S
//! ```
//!
//! `mu_i` and `v_i` are the factor `q(e | z_i, x_i) / N(e; 0, I)` of a view if the object has that yaw, which counts as a measurement of `e`; `mu`
//! is the mean latent of a tracklet's views. The exponents `a` and `b` make up for errors that views share.

use super::likeness::Likeness;
use crate::noise::Kernel;
use crate::problem::Problem;
use crate::semantics::unless_non_finite;
use crate::sighting::Sighting;
use crate::variable::{Key, Values};
use nalgebra::DVector;
use std::f64::consts::PI;
use vantage_dataset::{Crop, Pose, Viewpoint};
use vantage_model::{AnswerError, Information, LatentGaussian, ObservationModel};

/// Yaws that are summed over.
const YAWS: usize = 48;

/// How far a model is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodedSettings {
    /// Most views of a tracklet that are read, spread over it.
    pub views: usize,
    /// Of what the encoder tells: `a`.
    pub latent_exponent: f64,
    /// Of what the decoder tells of the side: `b`. With 0, tracklets of one object may have any yaws.
    pub side_exponent: f64,
}

impl Default for EncodedSettings {
    /// Fitted on pairs of tracklets of validation objects, in `sparse_loop`: see `docs/association.md`.
    fn default() -> Self {
        Self { views: 8, latent_exponent: 0.1, side_exponent: 0.2 }
    }
}

/// Likeness by a model's encoder and decoder.
#[derive(Clone, Copy)]
pub struct Encoded<'m> {
    model: &'m dyn ObservationModel,
    settings: EncodedSettings,
}

/// The views of a tracklet under each yaw.
#[derive(Clone, Debug)]
pub struct EncodedReading {
    by_yaw: Vec<ByYaw>,
    /// `log` of the mean over the yaws of the evidence alone.
    alone: f64,
}

#[derive(Clone, Debug)]
struct ByYaw {
    latent: LatentFactor,
    /// `b log p(m | mu, x)` over the views.
    side: f64,
}

/// The product of the views' factors: `exp(weighted . e - precision . e^2 / 2 + constant)`.
#[derive(Clone, Debug)]
struct LatentFactor {
    precision: DVector<f64>,
    weighted: DVector<f64>,
    constant: f64,
}

/// A crop, what is measured of it, and from where it was taken if the object has yaw 0.
struct View<'a> {
    crop: &'a Crop,
    measurement: DVector<f64>,
    viewpoint: Viewpoint,
}

impl<'m> Encoded<'m> {
    /// By this model.
    pub fn new(model: &'m dyn ObservationModel, settings: EncodedSettings) -> Self {
        Self { model, settings }
    }

    /// The views of a tracklet that can be used.
    fn views<'a>(
        &self,
        problem: &Problem<'a>,
        values: &Values,
        sightings: &[Sighting],
    ) -> Result<Vec<View<'a>>, AnswerError> {
        let position = values.get(Key::Object(0)).and_then(|value| value.position());
        let size = problem.object_size(values, 0, sightings);
        let (Some(position), Some(size)) = (position, size) else { return Ok(Vec::new()) };
        let upright = Pose::translation(position.x, position.y, position.z);
        let (n, most) = (sightings.len(), self.settings.views.max(1));
        let mut views = Vec::new();
        for i in 0..n.min(most) {
            let sighting = &sightings[if n <= most { i } else { (2 * i + 1) * n / (2 * most) }];
            let world_from_camera = problem.world_from_camera(values, sighting.step);
            let viewpoint = world_from_camera.and_then(|w| Viewpoint::new(&upright.inv_mul(&w), size));
            let crop = &problem.observations.detections[sighting.detection].masked_crop;
            let measurement = unless_non_finite(self.model.measure(crop))?;
            if let (Some(viewpoint), Some(measurement)) = (viewpoint, measurement) {
                views.push(View { crop, measurement, viewpoint });
            }
        }
        Ok(views)
    }

    /// What views tell if the object has a yaw; none where the model does not answer with numbers.
    fn under(&self, views: &[View<'_>], yaw: f64) -> Result<Option<ByYaw>, AnswerError> {
        let dim = self.model.latent_dim();
        let mut posteriors: Vec<LatentGaussian> = Vec::with_capacity(views.len());
        for view in views {
            match unless_non_finite(self.model.encode(view.crop, &view.viewpoint.turned(-yaw)))? {
                Some(posterior) if posterior.is_valid(dim) => posteriors.push(posterior),
                _ => return Ok(None),
            }
        }
        let latent = LatentFactor::of(dim, &posteriors);
        let side = if self.settings.side_exponent == 0.0 { 0.0 } else { self.side(views, yaw, &latent)? };
        Ok(Some(ByYaw { latent, side }))
    }

    /// `b` times the log-likelihood of the measurements at a yaw, up to a constant.
    fn side(&self, views: &[View<'_>], yaw: f64, latent: &LatentFactor) -> Result<f64, AnswerError> {
        let noise = self.model.noise();
        let kernel = Kernel::of_degrees_of_freedom(noise.degrees_of_freedom());
        let mean = latent.weighted.component_div(&latent.precision.add_scalar(1.0));
        let mut cost = 0.0;
        for view in views {
            let predicted = unless_non_finite(self.model.predict(&mean, &view.viewpoint.turned(-yaw)))?;
            let Some(predicted) = predicted else { continue };
            let off = noise.sqrt_information() * (&view.measurement - predicted);
            cost += kernel.loss(off.norm_squared(), off.len());
        }
        Ok(-self.settings.side_exponent * cost)
    }
}

impl LatentFactor {
    fn of(dim: usize, posteriors: &[LatentGaussian]) -> Self {
        let Information { precision, weighted_mean } = Information::of(dim, posteriors);
        let constant = |posterior: &LatentGaussian| -> f64 {
            let numbers = posterior.mean.iter().zip(&posterior.variance);
            numbers.map(|(mean, v)| -0.5 * (libm::log(2.0 * PI * v) + mean * mean / v)).sum()
        };
        // The prior stands in the information once, and in the evidence once.
        Self {
            precision: precision.add_scalar(-1.0),
            weighted: weighted_mean,
            constant: posteriors.iter().map(constant).sum(),
        }
    }

    /// `log` of the integral of a product of factors with the prior.
    fn log_evidence(factors: &[&LatentFactor]) -> f64 {
        let Some(first) = factors.first() else { return 0.0 };
        let of = |i: usize| {
            let precision = 1.0 + factors.iter().map(|factor| factor.precision[i]).sum::<f64>();
            let weighted: f64 = factors.iter().map(|factor| factor.weighted[i]).sum();
            0.5 * (weighted * weighted / precision - libm::log(precision))
        };
        factors.iter().map(|factor| factor.constant).sum::<f64>()
            + (0..first.precision.len()).map(of).sum::<f64>()
    }
}

impl Likeness for Encoded<'_> {
    type Reading = Option<EncodedReading>;

    fn read(
        &self,
        problem: &Problem<'_>,
        values: &Values,
        sightings: &[Sighting],
    ) -> Result<Self::Reading, AnswerError> {
        let views = self.views(problem, values, sightings)?;
        if views.is_empty() {
            return Ok(None);
        }
        let mut by_yaw = Vec::with_capacity(YAWS);
        for k in 0..YAWS {
            let Some(under) = self.under(&views, 2.0 * PI * k as f64 / YAWS as f64)? else { return Ok(None) };
            by_yaw.push(under);
        }
        let alone = log_mean(by_yaw.iter().map(|under| self.log_evidence(&[under])));
        Ok(Some(EncodedReading { by_yaw, alone }))
    }

    fn log_ratio(&self, readings: &[(&Self::Reading, f64)]) -> f64 {
        let read: Vec<(&EncodedReading, f64)> =
            readings.iter().filter_map(|(reading, heading)| Some((reading.as_ref()?, *heading))).collect();
        // The yaw of the object in the frame of a reading is that in the world less the frame's heading.
        let shift = |heading: f64| libm::round(heading * YAWS as f64 / (2.0 * PI)) as i64;
        let together = log_mean((0..YAWS as i64).map(|k| {
            let under = read.iter().map(|(reading, heading)| {
                &reading.by_yaw[(k - shift(*heading)).rem_euclid(YAWS as i64) as usize]
            });
            self.log_evidence(&under.collect::<Vec<_>>())
        }));
        together - read.iter().map(|(reading, _)| reading.alone).sum::<f64>()
    }
}

impl Encoded<'_> {
    fn log_evidence(&self, under: &[&ByYaw]) -> f64 {
        let latents: Vec<&LatentFactor> = under.iter().map(|under| &under.latent).collect();
        self.settings.latent_exponent * LatentFactor::log_evidence(&latents)
            + under.iter().map(|under| under.side).sum::<f64>()
    }
}

fn log_mean(logs: impl Iterator<Item = f64>) -> f64 {
    let logs: Vec<f64> = logs.collect();
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return largest;
    }
    let sum: f64 = logs.iter().map(|log| libm::exp(log - largest)).sum();
    largest + libm::log(sum / logs.len() as f64)
}
