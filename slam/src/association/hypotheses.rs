//! The engine: all hypotheses that are worth keeping, with their weights.

use super::account::{AssociationError, GivenUp, Work};
use super::choice::Frame;
use super::estimator::{Addition, LocalEstimator, Unsolved};
use super::expansion::{Continuation, expand};
use super::hypothesis::Hypothesis;
use super::limits::{Limits, Merging};
use super::mass::{log_sum, prune};

/// Hypotheses over all choices so far.
pub struct Hypotheses<E> {
    limits: Limits,
    hypotheses: Vec<Hypothesis<E>>,
    given_up: GivenUp,
    work: Work,
    /// Whether nothing was taken in since all was brought up to date.
    is_settled: bool,
}

impl<E> Hypotheses<E> {
    /// One, with no choice made.
    pub fn new<'m>(estimator: E, limits: Limits) -> Self
    where
        E: LocalEstimator<'m>,
    {
        let hypotheses = vec![Hypothesis::new(estimator)];
        Self {
            limits,
            hypotheses,
            given_up: GivenUp::default(),
            work: Work { most: 1, ..Work::default() },
            is_settled: false,
        }
    }

    /// The hypotheses that are left, the most likely first as of the last choice or [`Hypotheses::settle`].
    pub fn all(&self) -> &[Hypothesis<E>] {
        &self.hypotheses
    }

    /// The most likely one; none after an error.
    pub fn best(&self) -> Option<&Hypothesis<E>> {
        self.hypotheses.first()
    }

    /// What was given up.
    pub fn given_up(&self) -> GivenUp {
        self.given_up
    }

    /// What was done.
    pub fn work(&self) -> Work {
        self.work
    }

    /// The entropy of the weights, nats.
    pub fn entropy(&self) -> f64 {
        self.hypotheses.iter().map(|h| -h.weight() * if h.weight() > 0.0 { h.log_weight } else { 0.0 }).sum()
    }

    /// The probability that a choice is what `label` says.
    pub fn probability(&self, choice: usize, label: usize) -> f64 {
        let takes = |hypothesis: &&Hypothesis<E>| hypothesis.label(choice) == Some(label);
        self.hypotheses.iter().filter(takes).map(Hypothesis::weight).sum()
    }

    /// Takes in what is certain; `addition` may depend on each hypothesis.
    ///
    /// # Errors
    /// If no hypothesis can take it in.
    pub fn observe<'m>(
        &mut self,
        addition: impl Fn(&Hypothesis<E>) -> Addition<'m>,
    ) -> Result<(), AssociationError>
    where
        E: LocalEstimator<'m>,
    {
        self.is_settled = false;
        self.keep_solved(|hypothesis| {
            let addition = addition(hypothesis);
            hypothesis.estimator.add(&addition)
        })
    }

    /// Brings estimates and weights up to date, and merges hypotheses that have become one.
    ///
    /// # Errors
    /// If no hypothesis has an estimate.
    pub fn settle<'m>(&mut self) -> Result<(), AssociationError>
    where
        E: LocalEstimator<'m>,
    {
        self.work.updates += self.hypotheses.len();
        self.keep_solved(|hypothesis| hypothesis.estimator.update())?;
        self.weigh_anew();
        self.is_settled = true;
        Ok(())
    }

    /// Brings estimates to their maxima by all their factors, and weights with them: what is slow, and for the end.
    ///
    /// # Errors
    /// If no hypothesis has an estimate.
    pub fn refine<'m>(&mut self) -> Result<(), AssociationError>
    where
        E: LocalEstimator<'m>,
    {
        self.settle()?;
        self.keep_solved(|hypothesis| hypothesis.estimator.solve_anew())?;
        self.weigh_anew();
        Ok(())
    }

    /// Takes weights from the estimates, and merges what has become one.
    fn weigh_anew<'m>(&mut self)
    where
        E: LocalEstimator<'m>,
    {
        if self.hypotheses.len() > 1 {
            let masses: Vec<f64> = self.hypotheses.iter().map(Self::log_mass).collect();
            self.hypotheses.iter_mut().zip(&masses).for_each(|(h, mass)| h.log_weight = *mass);
            let (kept, dropped) = prune(&masses, &self.limits);
            self.drop_mass(dropped);
            self.reorder(&kept);
            self.normalize();
            self.merge();
        }
    }

    /// Takes in choices of one moment; `frame` says for each hypothesis what they are.
    ///
    /// # Errors
    /// If no hypothesis has an estimate, or a choice no possible alternative.
    pub fn choose<'m>(&mut self, frame: impl Fn(&Hypothesis<E>) -> Frame<'m>) -> Result<(), AssociationError>
    where
        E: LocalEstimator<'m>,
    {
        let mut frames: Vec<Frame<'m>> = self.hypotheses.iter().map(&frame).collect();
        if !self.is_settled && frames.iter().any(Frame::is_informed) {
            self.settle()?;
            frames = self.hypotheses.iter().map(&frame).collect();
        }
        let number = frames.iter().flat_map(|frame| &frame.choices).map(|choice| choice.number).next();
        let Some(number) = number else {
            for (hypothesis, frame) in self.hypotheses.iter_mut().zip(frames) {
                hypothesis.log_prior += frame.log_weight;
                hypothesis.log_weight += frame.log_weight;
            }
            self.normalize();
            return Ok(());
        };
        let before = self.hypotheses.len();
        let mut continuations: Vec<Continuation<'m>> = Vec::new();
        let mut dropped = 0.0;
        for (parent, (hypothesis, frame)) in self.hypotheses.iter().zip(frames).enumerate() {
            let log_mass = hypothesis.log_weight;
            let (more, share) = expand(hypothesis, parent, log_mass, frame, &self.limits);
            dropped += share * hypothesis.weight();
            continuations.extend(more);
        }
        self.work.weighed += continuations.len();
        self.drop_mass(dropped);
        let masses: Vec<f64> = continuations.iter().map(|continuation| continuation.log_mass).collect();
        let (kept, dropped) = prune(&masses, &self.limits);
        self.drop_mass(dropped);
        if kept.is_empty() {
            return Err(AssociationError::Impossible(number));
        }
        self.work.plain += usize::from(before == 1 && kept.len() == 1);
        self.work.most = self.work.most.max(kept.len());
        self.grow(continuations, &kept)
    }

    /// Puts the kept continuations in the place of their parents.
    fn grow<'m>(
        &mut self,
        continuations: Vec<Continuation<'m>>,
        kept: &[usize],
    ) -> Result<(), AssociationError>
    where
        E: LocalEstimator<'m>,
    {
        self.is_settled = false;
        let mut uses = vec![0; self.hypotheses.len()];
        kept.iter().for_each(|&index| uses[continuations[index].parent] += 1);
        let mut parents: Vec<Option<Hypothesis<E>>> =
            std::mem::take(&mut self.hypotheses).into_iter().map(Some).collect();
        let mut additions = Vec::with_capacity(kept.len());
        let mut continuations: Vec<Option<Continuation<'m>>> = continuations.into_iter().map(Some).collect();
        for &index in kept {
            let Some(continuation) = continuations[index].take() else { continue };
            let parent = &mut parents[continuation.parent];
            uses[continuation.parent] -= 1;
            let taken = if uses[continuation.parent] == 0 { parent.take() } else { parent.clone() };
            let Some(mut hypothesis) = taken else { continue };
            hypothesis.log_prior += continuation.log_prior;
            hypothesis.log_weight = continuation.log_mass;
            continuation.verdicts.iter().for_each(|verdict| hypothesis.record(*verdict));
            self.hypotheses.push(hypothesis);
            additions.push(continuation.additions);
        }
        let mut additions = additions.into_iter();
        self.keep_solved(|hypothesis| {
            additions
                .next()
                .unwrap_or_default()
                .iter()
                .try_for_each(|addition| hypothesis.estimator.add(addition))
        })?;
        self.normalize();
        Ok(())
    }

    fn log_mass<'m>(hypothesis: &Hypothesis<E>) -> f64
    where
        E: LocalEstimator<'m>,
    {
        hypothesis.log_prior + hypothesis.estimator.log_evidence()
    }

    /// Does something with each hypothesis, and drops those that fail.
    fn keep_solved(
        &mut self,
        mut what: impl FnMut(&mut Hypothesis<E>) -> Result<(), Unsolved>,
    ) -> Result<(), AssociationError> {
        let mut failure = None;
        let mut dropped = 0.0;
        self.hypotheses.retain_mut(|hypothesis| match what(hypothesis) {
            Ok(()) => true,
            Err(error) => {
                failure = Some(error);
                dropped += libm::exp(hypothesis.log_weight);
                false
            }
        });
        match failure {
            Some(error) if self.hypotheses.is_empty() => Err(error.into()),
            Some(_) => {
                self.drop_mass(dropped);
                self.normalize();
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn reorder(&mut self, order: &[usize]) {
        let mut old: Vec<Option<Hypothesis<E>>> =
            std::mem::take(&mut self.hypotheses).into_iter().map(Some).collect();
        self.hypotheses = order.iter().filter_map(|&index| old[index].take()).collect();
    }

    /// Merges each hypothesis into a likelier one that recent verdicts and the newest pose do not tell it from.
    fn merge<'m>(&mut self)
    where
        E: LocalEstimator<'m>,
    {
        let Some(Merging { window, distance }) = self.limits.merging else { return };
        let mut kept: Vec<Hypothesis<E>> = Vec::with_capacity(self.hypotheses.len());
        for hypothesis in std::mem::take(&mut self.hypotheses) {
            let is_same = |other: &&mut Hypothesis<E>| {
                other.agrees(&hypothesis, window)
                    && other.estimator.distance(&hypothesis.estimator) <= distance
            };
            match kept.iter_mut().find(is_same) {
                Some(other) => {
                    let mass = log_sum([other.log_weight, hypothesis.log_weight].into_iter());
                    other.log_prior += mass - other.log_weight;
                    other.log_weight = mass;
                    let share = libm::exp(hypothesis.log_weight);
                    self.given_up.merged = 1.0 - (1.0 - self.given_up.merged) * (1.0 - share);
                }
                None => kept.push(hypothesis),
            }
        }
        self.hypotheses = kept;
    }

    fn drop_mass(&mut self, share: f64) {
        self.given_up.dropped = 1.0 - (1.0 - self.given_up.dropped) * (1.0 - share.clamp(0.0, 1.0));
    }

    /// Makes the weights those of the hypotheses that are left.
    fn normalize(&mut self) {
        let total = log_sum(self.hypotheses.iter().map(|hypothesis| hypothesis.log_weight));
        self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.log_weight -= total);
    }
}
