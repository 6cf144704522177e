//! P(X, O, E, W | U, Z^g, Z^s): semantic, with the last layer `W` of the model's decoder learnt by expectation maximization (Eq. 25-26),
//! from one drive on to the next. What reads crops, `m(z)`, stays as it is.
//!
//! With the features `phi` of a view, draws of the posterior `k` and the weight `w` of each crop,
//!
//! ```text
//! E:  A = sum_k sum_v w phi phi^T / K,   B = sum_k sum_v w (m(z) - W_0 phi) phi^T / K
//! M:  W - W_0 = B (A + R + r I)^-1,      R = n mean phi phi^T of replayed views, r a thousandth of its mean diagonal
//! ```
//!
//! which is the mode of a matrix normal whose rows are of the model's noise. Replayed views are of latents drawn from their prior, from the
//! drive's own viewpoints turned at random: of those the layer shall predict what it did, and they count as `n` views.

use super::semantic::{Drawn, SeenView};
use super::{Estimator, Learner, Learnt, Semantic, gain_a_crop};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::{KEPT, LayerLesson, Lesson};
use crate::noise::Kernel;
use crate::semantics::unless_non_finite;
use crate::settings::{SemanticSettings, Settings};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use vantage_dataset::{Observations, Seed, Stream};
use vantage_model::{AnswerError, LastLayer};

/// Draws of the posterior a round.
const DRAWS: usize = 4;
/// The stream of draws and replay.
pub(super) const DECODER: &str = "decoder";
/// Replayed views.
const REPLAYED: usize = 512;
/// How many views they count as.
const REPLAY_COUNT: f64 = 100.0;
/// Of the mean square of the features, a prior of each weight that replayed views do not see.
const RIDGE: f64 = 1e-3;

/// [`Semantic`] with a last layer that it learns.
pub struct DecoderAdapted<'m> {
    settings: Settings,
    layer: &'m dyn LastLayer,
}

impl<'m> DecoderAdapted<'m> {
    /// An estimator that reads crops by the model of `layer`.
    pub fn new(settings: &Settings, layer: &'m dyn LastLayer) -> Self {
        Self { settings: *settings, layer }
    }

    /// The estimate by the model with a change, and what was seen; of no crops of the `hidden` detections.
    pub(super) fn by(
        &self,
        change: Option<&DMatrix<f64>>,
        (observations, hidden): (&Observations, &BTreeSet<usize>),
        random: &mut Stream,
    ) -> Result<Drawn, EstimateError> {
        let changed = change.map(|change| self.layer.changed(change)).transpose()?;
        let model = changed.as_deref().unwrap_or(self.layer.model());
        Semantic::new(&self.settings, model).without(hidden).drawn(observations, (DRAWS, random))
    }

    /// The estimate by the model with a change, and its evidence.
    pub(super) fn evidenced(
        &self,
        change: Option<&DMatrix<f64>>,
        observations: &Observations,
    ) -> Result<(Estimate, Option<f64>), EstimateError> {
        let changed = change.map(|change| self.layer.changed(change)).transpose()?;
        let model = changed.as_deref().unwrap_or(self.layer.model());
        Semantic::new(&self.settings, model).evidenced(observations)
    }

    /// Of an estimate by what was `known`, over the model as it was trained.
    pub(super) fn gain(
        &self,
        known: Option<&LayerLesson>,
        by_known: (&Estimate, Option<f64>),
        observations: &Observations,
    ) -> Result<Option<f64>, EstimateError> {
        if known.is_none() {
            return Ok(gain_a_crop(by_known, by_known));
        }
        let (frozen, evidence) = self.evidenced(None, observations)?;
        Ok(gain_a_crop(by_known, (&frozen, evidence)))
    }

    /// The features of a view, and what the layer that training left does not tell of it.
    fn read(&self, view: &SeenView) -> Result<(DVector<f64>, DVector<f64>), AnswerError> {
        let phi = self.layer.features(&view.latent, &view.viewpoint)?;
        let predicted = self.layer.model().predict(&view.latent, &view.viewpoint)?;
        Ok((phi, &view.measurement - predicted))
    }

    /// What was known `before`, with what was seen of a drive.
    pub(super) fn lesson(
        &self,
        before: Option<&LayerLesson>,
        seen: &[SeenView],
        random: &mut Stream,
    ) -> Result<Option<LayerLesson>, AnswerError> {
        let Some(first) = seen.first() else { return Ok(None) };
        let features = self.layer.features(&first.latent, &first.viewpoint)?.len();
        let (mut information, mut moment) = match before {
            Some(of) => (&of.information * KEPT, &of.moment * KEPT),
            None => (DMatrix::zeros(features, features), DMatrix::zeros(first.measurement.len(), features)),
        };
        for view in seen {
            let Some((phi, residual)) = unless_non_finite(self.read(view))? else { continue };
            information.ger(view.weight, &phi, &phi, 1.0);
            moment.ger(view.weight, &residual, &phi, 1.0);
        }
        let mut prior = DMatrix::zeros(features, features);
        for _ in 0..REPLAYED {
            let latent = DVector::from_fn(first.latent.len(), |_, _| random.normal());
            let viewpoint = seen[random.below(seen.len())].viewpoint.turned(random.uniform(0.0, TAU));
            let Some(phi) = unless_non_finite(self.layer.features(&latent, &viewpoint))? else { continue };
            prior.ger(REPLAY_COUNT / REPLAYED as f64, &phi, &phi, 1.0);
        }
        let ridge = RIDGE * prior.trace() / features as f64;
        let precision = &information + prior + DMatrix::from_diagonal_element(features, features, ridge);
        let Some(root) = precision.cholesky() else { return Ok(None) };
        let change = root.solve(&moment.transpose()).transpose();
        let is_finite = change.iter().all(|x| x.is_finite());
        Ok(is_finite.then_some(LayerLesson { information, moment, change }))
    }
}

/// Of draws and replay: another one on every drive.
pub(super) fn stream(name: &'static str, observations: &Observations) -> Stream {
    let sides = observations.detections.iter().flat_map(|of| [of.bounding_box.min.x, of.bounding_box.max.y]);
    let drive = sides.fold(0u64, |drive, side| drive.rotate_left(7) ^ side.to_bits());
    Seed(0).stream(name, drive)
}

impl Estimator for DecoderAdapted<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Ok(self.learn(observations, &Lesson::default())?.estimate)
    }
}

/// A round after which the solver comes to no maximum is undone, and the drive teaches no more.
impl Learner for DecoderAdapted<'_> {
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError> {
        let known = before.decoder.as_ref();
        let mut random = stream(DECODER, observations);
        let read = (observations, &BTreeSet::new());
        let (mut estimate, evidence, mut seen) = self.by(known.map(|of| &of.change), read, &mut random)?;
        let gain = self.gain(known, (&estimate, evidence), observations)?;
        let mut learnt = known.cloned();
        for _ in 0..self.settings.layer.rounds {
            let Some(views) = &seen else { break };
            let Some(lesson) = self.lesson(known, views, &mut random)? else { break };
            let (next, _, seen_next) = self.by(Some(&lesson.change), read, &mut random)?;
            if seen_next.is_none() {
                break;
            }
            (estimate, seen, learnt) = (next, seen_next, Some(lesson));
        }
        Ok(Learnt { estimate, lesson: Lesson { decoder: learnt, ..before.clone() }, gain })
    }
}

/// A control: [`DecoderAdapted`], taught after each drive by views that are known to the truth, and not on it.
pub struct DecoderTaught<'m> {
    of: DecoderAdapted<'m>,
    seen: &'m [SeenView],
}

impl<'m> DecoderTaught<'m> {
    /// An estimator of a drive on which these views were seen.
    pub fn new(settings: &Settings, layer: &'m dyn LastLayer, seen: &'m [SeenView]) -> Self {
        Self { of: DecoderAdapted::new(settings, layer), seen }
    }
}

impl DecoderTaught<'_> {
    /// Of a crop, as its factor has it under what is known.
    fn weight(&self, view: &SeenView, known: Option<&LayerLesson>) -> Result<f64, AnswerError> {
        let Some((phi, residual)) = unless_non_finite(self.of.read(view))? else { return Ok(0.0) };
        let SemanticSettings { noise_scale, information_scale, .. } = self.of.settings.semantics;
        let noise = self.of.layer.model().noise();
        let residual = known.map_or_else(|| residual.clone(), |of| &residual - &of.change * &phi);
        let whitened = noise.sqrt_information() * residual / noise_scale;
        let kernel = Kernel::of_degrees_of_freedom(noise.degrees_of_freedom());
        Ok(information_scale * kernel.weight(whitened.norm_squared(), whitened.len()))
    }
}

impl Estimator for DecoderTaught<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Semantic::new(&self.of.settings, self.of.layer.model()).estimate(observations)
    }
}

impl Learner for DecoderTaught<'_> {
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError> {
        let known = before.decoder.as_ref();
        let mut random = stream(DECODER, observations);
        let change = known.map(|of| &of.change);
        let (estimate, evidence) = self.of.evidenced(change, observations)?;
        let gain = self.of.gain(known, (&estimate, evidence), observations)?;
        let mut seen = self.seen.to_vec();
        for view in &mut seen {
            view.weight *= self.weight(view, known)?;
        }
        let learnt = self.of.lesson(known, &seen, &mut random)?;
        let lesson = Lesson { decoder: learnt.or_else(|| known.cloned()), ..before.clone() };
        Ok(Learnt { estimate, lesson, gain })
    }
}
