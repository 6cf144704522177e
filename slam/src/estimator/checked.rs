//! P(X, O, E, theta | U, Z^g, Z^s) with what is learnt on the run, kept only where it predicts crops that it did not see.
//!
//! A round of learning is kept if, learnt without them, it makes two sets of crops more probable than what was there before:
//!
//! - the later views: of each object the last third;
//! - another session: of each object all views before the longest time that it was out of sight.
//!
//! ```text
//! log p(Z_hidden | Z_read, theta) = log p(Z_hidden, Z_read | theta) - log p(Z_read | theta)
//! ```
//!
//! Both terms are evidences by Laplace's method, over the trajectory, the objects and their latents. Otherwise the round is rolled back,
//! and so it is where with it the solver does not converge, and where no object has a second session.

use super::refitted::most_probable;
use super::{Estimator, Semantic};
use crate::domain::DomainPrior;
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::settings::{SemanticSettings, Settings};
use crate::sighting::sightings;
use crate::solve::Outcome;
use std::collections::BTreeSet;
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// Of an object's views, the share before the later ones.
const EARLIER: (usize, usize) = (2, 3);
/// Steps out of sight that end a session.
const SESSION_GAP: usize = 20;

/// [`Semantic`] with the noise refitted in a first round, and in a domain that it learns in a second.
pub struct Checked<'m> {
    settings: Settings,
    model: &'m dyn ObservationModel,
    domain: DomainPrior,
}

/// What was learnt: how crops are read.
#[derive(Clone, Copy, PartialEq)]
struct Learnt {
    semantics: SemanticSettings,
    domain: Option<DomainPrior>,
}

/// The log-evidence of what is read, nats, and whether the solver came to the maximum that it is about.
#[derive(Clone, Copy)]
struct Evidence {
    log: Option<f64>,
    is_at_maximum: bool,
}

/// A run whose crops are read but for the hidden ones, by detection.
struct Reading<'r> {
    estimator: &'r Checked<'r>,
    observations: &'r Observations,
    hidden: BTreeSet<usize>,
    /// Evidences that are known.
    known: Vec<(Learnt, Evidence)>,
}

impl<'m> Checked<'m> {
    /// An estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: &'m dyn ObservationModel, domain: &DomainPrior) -> Self {
        Self { settings: *settings, model, domain: *domain }
    }

    fn semantic(&self, learnt: &Learnt) -> Semantic<'m> {
        let semantic = Semantic::new(&Settings { semantics: learnt.semantics, ..self.settings }, self.model);
        match &learnt.domain {
            Some(prior) => semantic.in_domain(prior),
            None => semantic,
        }
    }
}

impl Reading<'_> {
    fn evidence(&mut self, learnt: &Learnt) -> Result<Evidence, EstimateError> {
        if let Some((_, evidence)) = self.known.iter().find(|(known, _)| known == learnt) {
            return Ok(*evidence);
        }
        let semantic = self.estimator.semantic(learnt).without(&self.hidden);
        let (estimate, evidence) = semantic.evidenced(self.observations)?;
        let is_at_maximum = matches!(estimate.outcome, Outcome::Converged | Outcome::Stalled);
        let evidence = Evidence { log: evidence, is_at_maximum };
        self.known.push((*learnt, evidence));
        Ok(evidence)
    }

    /// The noise refitted on what is read.
    fn refitted(&mut self, before: &Learnt) -> Result<Learnt, EstimateError> {
        let by = |semantics: &SemanticSettings| {
            Ok(((), self.evidence(&Learnt { semantics: *semantics, ..*before })?.log))
        };
        let (semantics, ()) = most_probable(before.semantics, by)?;
        Ok(Learnt { semantics, ..*before })
    }
}

impl Estimator for Checked<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        let reading = |hidden| Reading { estimator: self, observations, hidden, known: Vec::new() };
        let mut whole = reading(BTreeSet::new());
        let mut checks = [later_views(observations), other_session(observations)].map(reading);
        let told = Learnt { semantics: self.settings.semantics, domain: None };
        let mut kept = told;
        let mut kept_in = [told; 2];

        let mut refitted = kept_in;
        for (check, learnt) in checks.iter_mut().zip(&mut refitted) {
            *learnt = check.refitted(learnt)?;
        }
        if predicts_better(&mut whole, &mut checks, &kept_in, &refitted)? {
            kept = whole.refitted(&kept)?;
            kept_in = refitted;
        }
        let in_domain = kept_in.map(|learnt| Learnt { domain: Some(self.domain), ..learnt });
        if predicts_better(&mut whole, &mut checks, &kept_in, &in_domain)? {
            kept.domain = Some(self.domain);
        }
        self.semantic(&kept).estimate(observations)
    }
}

/// Whether in each check, what was learnt in it makes its hidden crops more probable than what was there before.
fn predicts_better(
    whole: &mut Reading<'_>,
    checks: &mut [Reading<'_>; 2],
    before: &[Learnt; 2],
    learnt: &[Learnt; 2],
) -> Result<bool, EstimateError> {
    for (check, (before, learnt)) in checks.iter_mut().zip(before.iter().zip(learnt)) {
        if check.hidden.is_empty() {
            return Ok(false);
        }
        let mut of = |what: &Learnt| -> Result<[Evidence; 2], EstimateError> {
            Ok([whole.evidence(what)?, check.evidence(what)?])
        };
        let (learnt, before) = (of(learnt)?, of(before)?);
        let log_predictive = |[all, read]: [Evidence; 2]| Some(all.log? - read.log?);
        let gain = log_predictive(learnt).zip(log_predictive(before)).map(|(new, old)| new - old);
        let converged = learnt.iter().all(|evidence| evidence.is_at_maximum);
        if !converged || gain.is_none_or(|gain| gain <= 0.0) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The detections of each object's last third.
fn later_views(observations: &Observations) -> BTreeSet<usize> {
    let (of_track, _) = sightings(observations);
    let later = of_track.values().flat_map(|of| &of[(of.len() * EARLIER.0).div_ceil(EARLIER.1)..]);
    later.map(|sighting| sighting.detection).collect()
}

/// The detections of each object before it was longest out of sight; none of one that was always seen again soon.
fn other_session(observations: &Observations) -> BTreeSet<usize> {
    let (of_track, _) = sightings(observations);
    let before = of_track.values().flat_map(|of| {
        let gap = |at: &usize| of[*at].step - of[at - 1].step;
        let longest = (1..of.len()).rev().max_by_key(gap).filter(|at| gap(at) > SESSION_GAP);
        &of[..longest.unwrap_or(0)]
    });
    before.map(|sighting| sighting.detection).collect()
}
