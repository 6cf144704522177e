//! P(X, O, E, theta | U, Z^g, Z^s) with what is learnt on the run, kept only where it predicts crops that it did not see.
//!
//! A round of learning is kept if, learnt without them, it makes two sets of crops more probable than what was there before:
//!
//! - the [later views](super::hidden_views::later_views);
//! - [another session](super::hidden_views::other_session).
//!
//! ```text
//! log p(Z_hidden | Z_read, theta) = log p(Z_hidden, Z_read | theta) - log p(Z_read | theta)
//! ```
//!
//! Both terms are evidences by Laplace's method about one mode, over the trajectory, the objects and their latents. Bearings and sizes of
//! hidden views are read. A round is rolled back where with it the solver does not converge, and all are where a set is empty.

use super::hidden_views::{later_views, other_session};
use super::refitted::most_probable;
use super::{Estimator, Semantic, is_at_maximum};
use crate::domain::DomainPrior;
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::NoiseOdds;
use crate::settings::{SemanticSettings, Settings, SolverSettings};
use std::collections::BTreeSet;
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

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

    fn semantic(&self, learnt: &Learnt, solver: SolverSettings) -> Semantic<'m> {
        let settings = Settings { semantics: learnt.semantics, solver, ..self.settings };
        let semantic = Semantic::new(&settings, self.model);
        match &learnt.domain {
            Some(prior) => semantic.in_domain(prior),
            None => semantic,
        }
    }
}

impl Reading<'_> {
    /// All objects are taken for known ones, so that evidences are of the same crops.
    fn evidence(&mut self, learnt: &Learnt) -> Result<Evidence, EstimateError> {
        if let Some((_, evidence)) = self.known.iter().find(|(known, _)| known == learnt) {
            return Ok(*evidence);
        }
        let semantics = SemanticSettings { unknown_margin: None, ..learnt.semantics };
        let solver = SolverSettings { covariances: false, ..self.estimator.settings.solver };
        let semantic = self.estimator.semantic(&Learnt { semantics, ..*learnt }, solver);
        let (estimate, log) = semantic.without(&self.hidden).evidenced(self.observations)?;
        let evidence = Evidence { log, is_at_maximum: is_at_maximum(&estimate) };
        self.known.push((*learnt, evidence));
        Ok(evidence)
    }

    /// The noise refitted on what is read.
    fn refitted(&mut self, before: &Learnt) -> Result<Learnt, EstimateError> {
        let mut by = |semantics: &SemanticSettings| {
            Ok(((), self.evidence(&Learnt { semantics: *semantics, ..*before })?.log))
        };
        let first = by(&before.semantics)?;
        let (refit, ()) = most_probable(before.semantics, first, &NoiseOdds::default(), by)?;
        Ok(Learnt { semantics: refit.semantics, ..*before })
    }
}

impl Estimator for Checked<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        let reading = |hidden| Reading { estimator: self, observations, hidden, known: Vec::new() };
        let mut whole = reading(BTreeSet::new());
        let mut checks = [later_views(observations), other_session(observations)].map(reading);
        let mut kept = Learnt { semantics: self.settings.semantics, domain: None };
        if checks.iter().all(|check| !check.hidden.is_empty()) {
            let mut in_checks = [kept; 2];

            let [later, other] = &mut checks;
            let refitted = [later.refitted(&kept)?, other.refitted(&kept)?];
            if predicts_better(&mut whole, &mut checks, &in_checks, &refitted)? {
                let candidate = whole.refitted(&kept)?;
                if whole.evidence(&candidate)?.is_at_maximum {
                    (kept, in_checks) = (candidate, refitted);
                }
            }
            let in_domain = in_checks.map(|learnt| Learnt { domain: Some(self.domain), ..learnt });
            if predicts_better(&mut whole, &mut checks, &in_checks, &in_domain)? {
                let candidate = Learnt { domain: Some(self.domain), ..kept };
                if whole.evidence(&candidate)?.is_at_maximum {
                    kept = candidate;
                }
            }
        }
        self.semantic(&kept, self.settings.solver).estimate(observations)
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
        let mut evidences = |of: &Learnt| -> Result<[Evidence; 2], EstimateError> {
            Ok([whole.evidence(of)?, check.evidence(of)?])
        };
        let (old, new) = (evidences(before)?, evidences(learnt)?);
        let log_predictive = |[all, read]: [Evidence; 2]| Some(all.log? - read.log?);
        let gain = log_predictive(new).zip(log_predictive(old)).map(|(new, old)| new - old);
        let converged = new.iter().all(|evidence| evidence.is_at_maximum);
        if !converged || gain.is_none_or(|gain| gain <= 0.0) {
            return Ok(false);
        }
    }
    Ok(true)
}
