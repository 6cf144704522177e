//! P(X, O, E, W | U, Z^g, Z^s): [`DecoderAdapted`], each round of which is kept only where it predicts crops that it did not see.
//!
//! A round is kept if, learnt without them, it makes both sets of [hidden views](super::hidden_views) more probable than the round before:
//!
//! ```text
//! log p(Z_hidden | Z_read, W) = log p(Z_hidden, Z_read | W) - log p(Z_read | W)
//! ```
//!
//! Both terms are evidences by Laplace's method about one mode, over the trajectory, the objects and their latents; bearings and sizes of
//! hidden views are read. The first round that is not kept is the last, and so is one with which the solver comes to no maximum, or reads
//! other crops. Where a set is empty nothing is learnt. In a life the first round is compared with what earlier drives taught. Eq. 25-26.

use super::decoder_adapted::{DECODER, DecoderAdapted, stream};
use super::hidden_views::{later_views, other_session};
use super::{Estimator, Learner, Learnt, SeenView, crops_read, is_at_maximum};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::{LayerLesson, Lesson};
use crate::settings::{SemanticSettings, Settings, SolverSettings};
use nalgebra::DMatrix;
use std::collections::BTreeSet;
use vantage_dataset::{Observations, Stream};
use vantage_model::LastLayer;

/// [`DecoderAdapted`] with rounds that are checked.
pub struct DecoderChecked<'m> {
    rounds: usize,
    /// What is answered.
    of: DecoderAdapted<'m>,
    /// What is asked: of all objects as known ones, so that evidences are of the same crops.
    asked: DecoderAdapted<'m>,
}

/// How a set of hidden views is predicted after a round that was learnt without them.
struct Predicted {
    /// `log p(Z_hidden | Z_read, W)`, nats; `None` where it is not defined, or of no maximum.
    log_predictive: Option<f64>,
    /// Of each object, how many crops are read of all, and of those that are not hidden.
    crops: [Vec<usize>; 2],
    seen: Option<Vec<SeenView>>,
}

impl<'m> DecoderChecked<'m> {
    /// An estimator that reads crops by the model of `layer`.
    pub fn new(settings: &Settings, layer: &'m dyn LastLayer) -> Self {
        let semantics = SemanticSettings { unknown_margin: None, ..settings.semantics };
        let solver = SolverSettings { covariances: false, ..settings.solver };
        let asked = DecoderAdapted::new(&Settings { semantics, solver, ..*settings }, layer);
        Self { rounds: settings.layer.rounds, of: DecoderAdapted::new(settings, layer), asked }
    }

    fn predicted(
        &self,
        change: Option<&DMatrix<f64>>,
        (whole, of_all): &(Estimate, Option<f64>),
        (observations, hidden): (&Observations, &BTreeSet<usize>),
        random: &mut Stream,
    ) -> Result<Predicted, EstimateError> {
        let (part, of_read, seen) = self.asked.by(change, (observations, hidden), random)?;
        let log_predictive = of_all.zip(of_read).map(|(all, read)| all - read);
        let is_at_maximum = is_at_maximum(whole) && seen.is_some();
        let crops = [crops_read(whole), crops_read(&part)];
        Ok(Predicted { log_predictive: log_predictive.filter(|_| is_at_maximum), crops, seen })
    }

    /// The same after another round, from what earlier drives taught; `None` where that predicts no better, or teaches nothing.
    fn next(
        &self,
        (known, before): (Option<&LayerLesson>, &Predicted),
        read: (&Observations, &BTreeSet<usize>),
        random: &mut Stream,
    ) -> Result<Option<Predicted>, EstimateError> {
        let Some(views) = &before.seen else { return Ok(None) };
        let Some(lesson) = self.asked.lesson(known, views, random)? else { return Ok(None) };
        let change = Some(&lesson.change);
        let next = self.predicted(change, &self.asked.evidenced(change, read.0)?, read, random)?;
        let gain = next.log_predictive.zip(before.log_predictive).map(|(next, before)| next - before);
        Ok((next.crops == before.crops && gain.is_some_and(|gain| gain > 0.0)).then_some(next))
    }
}

impl Estimator for DecoderChecked<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Ok(self.learn(observations, &Lesson::default())?.estimate)
    }
}

/// A drive of which no round is kept teaches nothing: what was known is passed on as it is, and does not fade.
impl Learner for DecoderChecked<'_> {
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError> {
        let known = before.decoder.as_ref();
        let change = known.map(|of| &of.change);
        let read = (observations, &BTreeSet::new());
        let mut random = stream(DECODER, observations);
        let (mut estimate, evidence, mut seen) = self.of.by(change, read, &mut random)?;
        let gain = self.of.gain(known, (&estimate, evidence), observations)?;
        let mut learnt = known.cloned();
        let hidden = [later_views(observations), other_session(observations)];
        if hidden.iter().all(|hidden| !hidden.is_empty()) {
            let [later, other] = hidden.each_ref().map(|hidden| (observations, hidden));
            // Of its own, so that from one lesson unchecked rounds are the same.
            let mut of_checks = stream("decoder's check", observations);
            let whole = self.asked.evidenced(change, observations)?;
            let mut checks = [
                self.predicted(change, &whole, later, &mut of_checks)?,
                self.predicted(change, &whole, other, &mut of_checks)?,
            ];
            for _ in 0..self.rounds {
                let [before_later, before_other] = &checks;
                let Some(next_later) = self.next((known, before_later), later, &mut of_checks)? else {
                    break;
                };
                let Some(next_other) = self.next((known, before_other), other, &mut of_checks)? else {
                    break;
                };
                let Some(views) = &seen else { break };
                let Some(lesson) = self.of.lesson(known, views, &mut random)? else { break };
                let (next, _, seen_next) = self.of.by(Some(&lesson.change), read, &mut random)?;
                if seen_next.is_none() {
                    break;
                }
                (estimate, seen, learnt, checks) = (next, seen_next, Some(lesson), [next_later, next_other]);
            }
        }
        Ok(Learnt { estimate, lesson: Lesson { decoder: learnt, ..before.clone() }, gain })
    }
}
