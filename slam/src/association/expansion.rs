//! How a hypothesis continues: the joint ways to take the choices of a frame, weighed before any is solved for.

use super::choice::{Choice, Frame, Verdict};
use super::estimator::{Addition, LocalEstimator};
use super::hypothesis::Hypothesis;
use super::limits::Limits;
use super::local::{Local, Weighed};
use super::mass::prune;
use crate::variable::Key;
use std::rc::Rc;

/// One way on.
pub(super) struct Continuation<'m> {
    pub parent: usize,
    /// `log` of its mass, on the scale of its parent's.
    pub log_mass: f64,
    /// `log` of the priors that it adds.
    pub log_prior: f64,
    pub verdicts: Vec<Verdict>,
    pub additions: Vec<Addition<'m>>,
}

struct Partial {
    log_mass: f64,
    log_prior: f64,
    /// Which alternative of each choice so far.
    picks: Vec<usize>,
    claimed: Vec<usize>,
    local: Option<Rc<Local>>,
}

/// A partial way on and one alternative more, which its marginal does not count yet: most are dropped, and to condition is dear.
struct Extended {
    partial: Partial,
    weighed: Option<Weighed>,
}

impl Extended {
    fn condition(self) -> Partial {
        let Self { mut partial, weighed } = self;
        if let (Some(local), Some(weighed)) = (&partial.local, &weighed) {
            partial.local = Some(Rc::new(local.conditioned(weighed)));
        }
        partial
    }
}

impl Frame<'_> {
    /// Whether an estimate says anything of what is to be chosen: a factor that only fixes a new variable is as likely under all.
    pub(super) fn is_informed(&self) -> bool {
        let mut alternatives = self.choices.iter().flat_map(|choice| &choice.alternatives);
        alternatives.any(|alternative| alternative.addition.factors.len() > alternative.addition.fresh.len())
    }
}

/// The ways on from a hypothesis of mass `log_mass`, the best first, and the share of its mass that was dropped on the way.
pub(super) fn expand<'m, E: LocalEstimator<'m>>(
    hypothesis: &Hypothesis<E>,
    parent: usize,
    log_mass: f64,
    frame: Frame<'m>,
    limits: &Limits,
) -> (Vec<Continuation<'m>>, f64) {
    let local = joint(&hypothesis.estimator, &frame).map(Rc::new);
    let log_mass = log_mass + frame.log_weight;
    let start = Partial { log_mass, log_prior: frame.log_weight, picks: vec![], claimed: vec![], local };
    let mut partials = vec![start];
    let mut dropped = 0.0;
    let last = frame.choices.len().saturating_sub(1);
    for (i, choice) in frame.choices.iter().enumerate() {
        let mut next = Vec::new();
        for partial in &partials {
            extend(partial, choice, i == last, &mut next);
        }
        let masses: Vec<f64> = next.iter().map(|extended| extended.partial.log_mass).collect();
        let (kept, share) = prune(&masses, limits);
        dropped = 1.0 - (1.0 - dropped) * (1.0 - share);
        let mut next: Vec<Option<Extended>> = next.into_iter().map(Some).collect();
        partials = kept.into_iter().filter_map(|index| next[index].take()).map(Extended::condition).collect();
    }
    let as_continuation = |partial: Partial| {
        let picked = || frame.choices.iter().zip(&partial.picks);
        Continuation {
            parent,
            log_mass: partial.log_mass,
            log_prior: partial.log_prior,
            verdicts: picked()
                .map(|(choice, &pick)| Verdict {
                    choice: choice.number,
                    label: choice.alternatives[pick].label,
                })
                .collect(),
            additions: picked().map(|(choice, &pick)| choice.alternatives[pick].addition.clone()).collect(),
        }
    };
    (partials.into_iter().map(as_continuation).collect(), dropped)
}

/// The joint marginal of all that the choices of a frame join, as far as it is there.
fn joint<'m, E: LocalEstimator<'m>>(estimator: &E, frame: &Frame<'m>) -> Option<Local> {
    let mut keys: Vec<Key> = Vec::new();
    for alternative in frame.choices.iter().flat_map(|choice| &choice.alternatives) {
        let fresh = |key: &Key| alternative.addition.fresh.iter().any(|(other, _)| other == key);
        for factor in &alternative.addition.factors {
            keys.extend(factor.keys().iter().copied().filter(|key| !fresh(key)));
        }
    }
    keys.sort_unstable();
    keys.dedup();
    if frame.is_informed() {
        return estimator.joint(&keys);
    }
    let held: Option<Vec<_>> = keys.iter().map(|key| Some((*key, estimator.value(*key)?))).collect();
    let held = held?;
    let n = held.iter().map(|(_, value)| value.dim()).sum();
    Local::new(held, nalgebra::DMatrix::identity(n, n))
}

fn extend(partial: &Partial, choice: &Choice<'_>, is_last: bool, next: &mut Vec<Extended>) {
    for (pick, alternative) in choice.alternatives.iter().enumerate() {
        if alternative.claims.is_some_and(|object| partial.claimed.contains(&object)) {
            continue;
        }
        let addition = &alternative.addition;
        let mut log_mass = partial.log_mass + alternative.log_weight;
        let mut local = partial.local.clone();
        let mut weighed = None;
        if !addition.factors.is_empty() {
            if !addition.moved.is_empty() {
                local = local.map(|local| Rc::new(local.moved(&addition.moved)));
            }
            let Some(before) = &local else { continue };
            let Some(taken) = before.weigh(&addition.factors, &addition.fresh) else { continue };
            log_mass += taken.log_evidence;
            weighed = Some(taken);
        }
        local = local.filter(|_| !is_last);
        let mut picks = partial.picks.clone();
        picks.push(pick);
        let mut claimed = partial.claimed.clone();
        claimed.extend(alternative.claims);
        let log_prior = partial.log_prior + alternative.log_weight;
        next.push(Extended { partial: Partial { log_mass, log_prior, picks, claimed, local }, weighed });
    }
}
