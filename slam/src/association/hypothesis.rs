//! One history of verdicts, and the estimate under it.

use super::choice::Verdict;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Verdicts, the newest first; hypotheses share what they have in common.
#[derive(Debug)]
struct Link {
    verdict: Verdict,
    before: Option<Rc<Link>>,
}

impl Drop for Link {
    /// One by one: a long history must not end in deep recursion.
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(link) = next {
            match Rc::try_unwrap(link) {
                Ok(mut link) => next = link.before.take(),
                Err(_) => break,
            }
        }
    }
}

/// A way to take all choices so far.
#[derive(Clone, Debug)]
pub struct Hypothesis<E> {
    pub(super) estimator: E,
    /// `log` of the priors of all verdicts, and of mass merged into it.
    pub(super) log_prior: f64,
    /// `log` of its share of the mass of all.
    pub(super) log_weight: f64,
    newest: Option<Rc<Link>>,
    verdicts: usize,
}

impl<E> Hypothesis<E> {
    pub(super) fn new(estimator: E) -> Self {
        Self { estimator, log_prior: 0.0, log_weight: 0.0, newest: None, verdicts: 0 }
    }

    /// The estimate under it.
    pub fn estimator(&self) -> &E {
        &self.estimator
    }

    /// Its probability among the hypotheses that are left.
    pub fn weight(&self) -> f64 {
        libm::exp(self.log_weight)
    }

    /// Its verdicts, the newest first.
    pub fn newest_verdicts(&self) -> impl Iterator<Item = Verdict> {
        std::iter::successors(self.newest.as_deref(), |link| link.before.as_deref()).map(|link| link.verdict)
    }

    /// Its verdicts, the oldest first.
    pub fn verdicts(&self) -> Vec<Verdict> {
        let mut verdicts: Vec<Verdict> = self.newest_verdicts().collect();
        verdicts.reverse();
        verdicts
    }

    /// What it takes all choices to be, by their numbers.
    pub fn labels(&self) -> BTreeMap<usize, usize> {
        let mut labels = BTreeMap::new();
        for Verdict { choice, label } in self.newest_verdicts() {
            labels.entry(choice).or_insert(label);
        }
        labels
    }

    /// What it takes a choice to be.
    pub fn label(&self, choice: usize) -> Option<usize> {
        self.newest_verdicts().find(|verdict| verdict.choice == choice).map(|verdict| verdict.label)
    }

    pub(super) fn record(&mut self, verdict: Verdict) {
        self.newest = Some(Rc::new(Link { verdict, before: self.newest.take() }));
        self.verdicts += 1;
    }

    /// Whether the newest `window` verdicts of both, and so the number of all, are the same.
    pub(super) fn agrees(&self, other: &Self, window: usize) -> bool {
        self.verdicts == other.verdicts
            && self.verdicts >= window
            && self.newest_verdicts().take(window).eq(other.newest_verdicts().take(window))
    }
}
