//! P(X, O, E, theta | U, Z^g, Z^s) with what is learnt on the run, kept only where it predicts crops that it did not see.
//!
//! A round of learning is kept if, learnt without them, it makes two sets of crops more probable than what was there before:
//!
//! - the later views: of each object the last third;
//! - another session: of each object that was out of sight for more than [`SESSION_GAP`] steps, all views before it was so longest.
//!
//! ```text
//! log p(Z_hidden | Z_read, theta) = log p(Z_hidden, Z_read | theta) - log p(Z_read | theta)
//! ```
//!
//! Both terms are evidences by Laplace's method about one mode, over the trajectory, the objects and their latents. Bearings and sizes of
//! hidden views are read. A round is rolled back where with it the solver does not converge, and all are where a set is empty.

use super::refitted::most_probable;
use super::{Estimator, Semantic};
use crate::domain::DomainPrior;
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::NoiseOdds;
use crate::settings::{SemanticSettings, Settings, SolverSettings};
use crate::sighting::sightings;
use crate::solve::Outcome;
use std::collections::BTreeSet;
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// Of an object's views, the share before the later ones.
const EARLIER: (usize, usize) = (2, 3);
/// Steps without a whole box after which another session begins.
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
        let is_at_maximum = matches!(estimate.outcome, Outcome::Converged | Outcome::Stalled);
        let evidence = Evidence { log, is_at_maximum };
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

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use vantage_dataset::{BoundingBox, Camera, Crop, Detection, Pose};

    fn seen(tracks_and_steps: &[(usize, usize)]) -> Observations {
        let bounding_box = BoundingBox { min: Vector2::new(100.0, 100.0), max: Vector2::new(140.0, 140.0) };
        let detection = |&(track, step): &(usize, usize)| Detection {
            step,
            track,
            bounding_box,
            mask_pixels: 1600,
            center_depth: None,
            masked_crop: Crop::black(),
            boxed_crop: Crop::black(),
        };
        Observations {
            timestamps: (0..200).map(f64::from).collect(),
            camera: Camera::with_horizontal_fov(512, 384, 1.0),
            robot_from_camera: Pose::identity(),
            odometry: Vec::new(),
            detections: tracks_and_steps.iter().map(detection).collect(),
            landmarks: Vec::new(),
        }
    }

    #[test]
    fn of_each_object_the_last_third_is_hidden_whatever_the_order_of_detections() {
        let hidden = |views: &[(usize, usize)]| later_views(&seen(views)).into_iter().collect::<Vec<_>>();
        assert!(
            hidden(&[]).is_empty() && hidden(&[(0, 3)]).is_empty() && hidden(&[(0, 3), (0, 4)]).is_empty()
        );
        assert_eq!(hidden(&[(0, 1), (0, 2), (0, 3)]), [2]);
        assert_eq!(hidden(&[(0, 9), (1, 1), (0, 7), (1, 2), (0, 8), (1, 3)]), [0, 5]);
    }

    #[test]
    fn what_was_seen_before_the_longest_gap_is_another_session() {
        let hidden = |views: &[(usize, usize)]| other_session(&seen(views)).into_iter().collect::<Vec<_>>();
        assert!(hidden(&[]).is_empty() && hidden(&[(0, 5)]).is_empty());
        assert!(hidden(&[(0, 0), (0, SESSION_GAP)]).is_empty());
        assert_eq!(hidden(&[(0, 0), (0, SESSION_GAP + 1)]), [0]);
        let two_gaps = [(0, 0), (0, 30), (0, 31), (0, 80), (1, 5), (1, 6)];
        assert_eq!(hidden(&two_gaps), [0, 1, 2], "before the longer one, and of that object alone");
    }
}
