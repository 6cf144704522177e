//! Likeness by a model: the encoder tells which object it is, the decoder from which side it is seen.
//!
//! ```text
//! p(crops of S | one object) = 1/K sum_yaw  [ integral N(e; 0, I) prod_i N(mu_i; e, v_i) de ]^a  [ prod_i p(m(z_i) | mu, x_i) ]^b      i in S
//! ```
//!
//! `mu_i` and `v_i` are the factor `q(e | z_i, x_i) / N(e; 0, I)` of a view if the object has that yaw, which counts as a measurement of `e`; `mu`
//! is the mean latent of a tracklet's views. The exponents `a` and `b` make up for errors that views share.
//!
//! Latents alone count as if each tracklet had a yaw of its own: its latent is then a mixture over the yaws, which is taken for the Gaussian of
//! equal mean and variances.
//!
//! Of objects that are not the same a share `c` are copies: their latents are one, and their yaws are not. With `r` the ratio of latents alone
//! to each further tracklet, the ratio of all is divided by `1 - c + c r` for each. So of what tells that tracklets are of one object, latents
//! add no more than `-log c` for each beyond the first.

use super::copies::less_copies;
use super::likeness::{Heading, Likeness};
use super::view::{View, YAWS, log_mean, measured, views, yaws};
use crate::noise::Kernel;
use crate::problem::Problem;
use crate::semantics::unless_non_finite;
use crate::sighting::Sighting;
use crate::variable::Values;
use nalgebra::DVector;
use std::f64::consts::PI;
use vantage_model::{AnswerError, Information, LatentGaussian, ObservationModel};

/// How far a model is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodedSettings {
    /// Most views of a tracklet that are read, spread over it.
    pub views: usize,
    /// Of what the encoder tells: `a`.
    pub latent_exponent: f64,
    /// Of what the decoder tells of the side: `b`. With 0 latents count alone: each tracklet of an object may have a yaw of its own.
    pub side_exponent: f64,
    /// Share of objects that look like another one: `c`.
    pub copies: f64,
}

impl Default for EncodedSettings {
    /// Fitted on pairs of tracklets of validation objects, in `sparse_loop`: see `docs/association.md`.
    fn default() -> Self {
        Self { views: 8, latent_exponent: 0.1, side_exponent: 0.2, copies: 0.1 }
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
    /// By yaw in the frame of the reading.
    latents: Vec<LatentFactor>,
    /// `b log p(m | mu, x)` over the views, likewise.
    sides: Vec<f64>,
    /// What the views tell of the latent whatever the yaw.
    any_yaw: LatentFactor,
    /// `log` of the mean over the yaws of the evidence of latents and sides; and that of latents whatever the yaw.
    alone: [f64; 2],
}

/// The views of several tracklets if they are of one object, under each of its yaws in the world.
#[derive(Clone, Debug, Default)]
pub struct EncodedSum {
    count: usize,
    /// Variance of the heading of the first.
    first_variance: f64,
    /// Of the product of latent factors, `[yaws, dim]`.
    precision: Vec<f64>,
    weighted: Vec<f64>,
    constant: Vec<f64>,
    sides: Vec<f64>,
    /// Likewise, whatever the yaws.
    any_yaw: [Vec<f64>; 2],
    /// What each tracklet's evidence is alone, added up.
    alone: [f64; 2],
}

/// The product of the views' factors: `exp(weighted . e - precision . e^2 / 2 + constant)`.
#[derive(Clone, Debug)]
struct LatentFactor {
    precision: DVector<f64>,
    weighted: DVector<f64>,
    constant: f64,
}

/// A view, and what is measured of it.
type Measured<'a> = (View<'a>, DVector<f64>);

impl<'m> Encoded<'m> {
    /// By this model.
    pub fn new(model: &'m dyn ObservationModel, settings: EncodedSettings) -> Self {
        Self { model, settings }
    }

    /// What views tell if the object has a yaw; none where the model does not answer with numbers.
    fn under(&self, views: &[Measured<'_>], yaw: f64) -> Result<Option<(LatentFactor, f64)>, AnswerError> {
        let dim = self.model.latent_dim();
        let mut posteriors: Vec<LatentGaussian> = Vec::with_capacity(views.len());
        for (view, _) in views {
            match unless_non_finite(self.model.encode(view.crop, &view.viewpoint.turned(-yaw)))? {
                Some(posterior) if posterior.is_valid(dim) => posteriors.push(posterior),
                _ => return Ok(None),
            }
        }
        let latent = LatentFactor::of(dim, &posteriors);
        let side = if self.settings.side_exponent == 0.0 { 0.0 } else { self.side(views, yaw, &latent)? };
        Ok(Some((latent, side)))
    }

    /// `b` times the log-likelihood of the measurements at a yaw, up to a constant.
    fn side(&self, views: &[Measured<'_>], yaw: f64, latent: &LatentFactor) -> Result<f64, AnswerError> {
        let noise = self.model.noise();
        let kernel = Kernel::of_degrees_of_freedom(noise.degrees_of_freedom());
        let mean = latent.weighted.component_div(&latent.precision.add_scalar(1.0));
        let mut cost = 0.0;
        for (view, measurement) in views {
            let predicted = unless_non_finite(self.model.predict(&mean, &view.viewpoint.turned(-yaw)))?;
            let Some(predicted) = predicted else { continue };
            let off = noise.sqrt_information() * (measurement - predicted);
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

    /// The Gaussian of the mean and the variances that the mixture of factors has under the prior; of weights by their logarithms.
    fn mixture(factors: &[Self], log_weights: &[f64]) -> Self {
        let largest = log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = log_weights.iter().map(|log| libm::exp(log - largest)).sum();
        let dim = factors.first().map_or(0, |factor| factor.precision.len());
        let (mut mean, mut square) = (DVector::zeros(dim), DVector::zeros(dim));
        for (factor, log) in factors.iter().zip(log_weights) {
            let share = libm::exp(log - largest) / total;
            let variance = factor.precision.map(|precision| 1.0 / (1.0 + precision));
            let own = factor.weighted.component_mul(&variance);
            square += share * (variance + own.component_mul(&own));
            mean += share * own;
        }
        let variance = square - mean.component_mul(&mean);
        // No mixture tells less than nothing.
        let precision = variance.map(|variance| (1.0 / variance - 1.0).max(0.0));
        let weighted = mean.component_mul(&precision.add_scalar(1.0));
        Self { precision, weighted, constant: 0.0 }
    }

    /// `log` of the integral with the prior.
    fn log_evidence(&self) -> f64 {
        log_evidence(self.precision.as_slice(), self.weighted.as_slice(), self.constant)
    }
}

/// `log` of the integral of a product of factors with the prior.
fn log_evidence(precision: &[f64], weighted: &[f64], constant: f64) -> f64 {
    let of = |(precision, weighted): (&f64, &f64)| {
        0.5 * (weighted * weighted / (1.0 + precision) - libm::log(1.0 + precision))
    };
    constant + precision.iter().zip(weighted).map(of).sum::<f64>()
}

impl Likeness for Encoded<'_> {
    type Reading = Option<EncodedReading>;
    type Sum = EncodedSum;

    fn read(
        &self,
        problem: &Problem<'_>,
        values: &Values,
        sightings: &[Sighting],
    ) -> Result<Self::Reading, AnswerError> {
        let views = views(problem, values, sightings, self.settings.views);
        let views = measured(views, |crop| self.model.measure(crop))?;
        if views.is_empty() {
            return Ok(None);
        }
        let (mut latents, mut sides) = (Vec::with_capacity(YAWS), Vec::with_capacity(YAWS));
        for yaw in yaws() {
            let under = self.under(&views, yaw)?;
            let Some((latent, side)) = under else { return Ok(None) };
            latents.push(latent);
            sides.push(side);
        }
        let of_latents: Vec<f64> =
            latents.iter().map(|latent| self.settings.latent_exponent * latent.log_evidence()).collect();
        let with_sides = log_mean(of_latents.iter().zip(&sides).map(|(latent, side)| latent + side));
        let any_yaw = LatentFactor::mixture(&latents, &of_latents);
        let alone = [with_sides, self.settings.latent_exponent * any_yaw.log_evidence()];
        Ok(Some(EncodedReading { latents, sides, any_yaw, alone }))
    }

    fn add(&self, sum: &mut EncodedSum, reading: &Self::Reading, heading: Heading) {
        let Some(reading) = reading else { return };
        if sum.count == 0 {
            let dim = self.model.latent_dim();
            (sum.precision, sum.weighted) = (vec![0.0; YAWS * dim], vec![0.0; YAWS * dim]);
            (sum.constant, sum.sides) = (vec![0.0; YAWS], vec![0.0; YAWS]);
            sum.any_yaw = [vec![0.0; dim], vec![0.0; dim]];
            sum.first_variance = heading.variance;
        }
        sum.count += 1;
        (0..2).for_each(|of| sum.alone[of] += reading.alone[of]);
        // A robot that drives on knows its heading less and less: what lies between two views is the difference.
        reading.turned_into(sum, heading.yaw, (heading.variance - sum.first_variance).abs());
    }

    fn log_ratio(&self, sum: &EncodedSum) -> f64 {
        if sum.count < 2 {
            return 0.0;
        }
        let EncodedSettings { latent_exponent, side_exponent, copies, .. } = self.settings;
        let [precision, weighted] = &sum.any_yaw;
        let latents = latent_exponent * log_evidence(precision, weighted, 0.0) - sum.alone[1];
        let dim = self.model.latent_dim();
        let under = |k: usize| {
            let of = k * dim..(k + 1) * dim;
            let log = log_evidence(&sum.precision[of.clone()], &sum.weighted[of], sum.constant[k]);
            latent_exponent * log + sum.sides[k]
        };
        let all = if side_exponent == 0.0 { latents } else { log_mean((0..YAWS).map(under)) - sum.alone[0] };
        less_copies(all, latents, (sum.count, copies))
    }
}

impl EncodedReading {
    /// Adds the views under each yaw of the object in the world, if the frame's heading has this mean and variance.
    fn turned_into(&self, sum: &mut EncodedSum, heading: f64, variance: f64) {
        let step = 2.0 * PI / YAWS as f64;
        // The yaw of the object in the frame is that in the world less the frame's heading.
        let shift = libm::round(heading / step) as i64;
        let at = |k: i64| k.rem_euclid(YAWS as i64) as usize;
        let deviation = variance.sqrt() / step;
        let reach = (libm::ceil(3.0 * deviation) as i64).min(YAWS as i64 / 2);
        // The opposite yaw counts once.
        let weights: Vec<(i64, f64)> = (-reach..=reach.min(YAWS as i64 / 2 - 1))
            .map(|off| (off, if off == 0 { 0.0 } else { -0.5 * (off as f64 / deviation).powi(2) }))
            .collect();
        let log_total = log_mean(weights.iter().map(|(_, log)| *log)) + libm::log(weights.len() as f64);
        let blurred = |k: i64| {
            let logs = weights.iter().map(|(off, log)| log + self.sides[at(k + off)]);
            log_mean(logs) + libm::log(weights.len() as f64) - log_total
        };
        let add = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        add(&mut sum.any_yaw[0], self.any_yaw.precision.as_slice());
        add(&mut sum.any_yaw[1], self.any_yaw.weighted.as_slice());
        for k in 0..YAWS {
            let turned = k as i64 - shift;
            let latent = &self.latents[at(turned)];
            let of = k * latent.precision.len()..(k + 1) * latent.precision.len();
            add(&mut sum.precision[of.clone()], latent.precision.as_slice());
            add(&mut sum.weighted[of], latent.weighted.as_slice());
            sum.constant[k] += latent.constant;
            sum.sides[k] += blurred(turned);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_mixture_has_the_moments_of_its_parts() {
        let of = |mean: f64, variance: f64| {
            let precision = DVector::from_element(1, 1.0 / variance - 1.0);
            LatentFactor { precision, weighted: DVector::from_element(1, mean / variance), constant: 0.0 }
        };
        let mixed = LatentFactor::mixture(&[of(0.3, 0.1), of(-0.1, 0.2)], &[0.0, libm::log(3.0)]);
        let variance = 1.0 / (1.0 + mixed.precision[0]);
        // Means 0.3 and -0.1 with shares of a quarter and three quarters.
        assert_relative_eq!(mixed.weighted[0] * variance, 0.0, epsilon = 1e-12);
        assert_relative_eq!(variance, 0.25 * (0.1 + 0.09) + 0.75 * (0.2 + 0.01), epsilon = 1e-12);
        // Parts that are farther apart than the prior is wide tell nothing.
        let apart = LatentFactor::mixture(&[of(2.0, 0.1), of(-2.0, 0.1)], &[0.0, 0.0]);
        assert_eq!(apart.precision[0], 0.0);
        let one = LatentFactor::mixture(&[of(0.3, 0.1)], &[-7.0]);
        assert_relative_eq!(one.weighted[0], 3.0, epsilon = 1e-9);
    }
}
