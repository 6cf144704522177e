//! Ratios of likelihoods that hypotheses have in common, each worked out once.

use super::likeness::{Heading, Likeness};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Headings are told in so many steps of a turn.
const STEPS: f64 = 48.0;
/// Ratios that are held; what hypotheses ask for next is among the newest.
const RATIOS: usize = 20_000;
/// Sums that are held.
const SUMS: usize = 500;

/// A tracklet, how many of its sightings were read, and the heading in steps.
type Name = (usize, usize, i64);

/// What was read of a tracklet, in a frame of some heading.
pub(super) struct Part<'t, R> {
    name: Name,
    reading: &'t R,
    variance: f64,
}

impl<'t, R> Part<'t, R> {
    /// What was read of so many sightings of a tracklet.
    pub fn new(tracklet: usize, (sightings, reading): (usize, &'t R), heading: Heading) -> Self {
        let steps = libm::round(heading.yaw / (2.0 * PI) * STEPS) as i64;
        Self { name: (tracklet, sightings, steps), reading, variance: heading.variance }
    }

    fn heading(&self) -> Heading {
        Heading { yaw: self.name.2 as f64 * 2.0 * PI / STEPS, variance: self.variance }
    }
}

/// A likeness that does not answer twice.
pub(super) struct Ratios<'a, L: Likeness> {
    likeness: &'a L,
    ratios: RefCell<BTreeMap<Vec<Name>, f64>>,
    sums: RefCell<BTreeMap<Vec<Name>, L::Sum>>,
}

impl<'a, L: Likeness> Ratios<'a, L> {
    pub fn new(likeness: &'a L) -> Self {
        Self { likeness, ratios: RefCell::default(), sums: RefCell::default() }
    }

    pub fn likeness(&self) -> &'a L {
        self.likeness
    }

    /// [`Likeness::log_ratio`] of parts. Those of one name have one variance.
    pub fn log_ratio(&self, parts: &[Part<'_, L::Reading>]) -> f64 {
        let names: Vec<Name> = parts.iter().map(|part| part.name).collect();
        if let Some(ratio) = self.ratios.borrow().get(&names) {
            return *ratio;
        }
        let ratio = match parts.split_last() {
            Some((last, before)) => {
                let mut sum = self.sum(before, &names[..before.len()]);
                self.likeness.add(&mut sum, last.reading, last.heading());
                self.likeness.log_ratio(&sum)
            }
            None => self.likeness.log_ratio(&L::Sum::default()),
        };
        held(&mut self.ratios.borrow_mut(), RATIOS, names, ratio);
        ratio
    }

    /// All parts together: the longest beginning that is held, and what is left.
    fn sum(&self, parts: &[Part<'_, L::Reading>], names: &[Name]) -> L::Sum {
        let mut sums = self.sums.borrow_mut();
        let found = (0..=parts.len()).rev().find_map(|n| Some((n, sums.get(&names[..n])?.clone())));
        let (n, mut sum) = found.unwrap_or_default();
        for part in &parts[n..] {
            self.likeness.add(&mut sum, part.reading, part.heading());
        }
        if n < parts.len() {
            held(&mut sums, SUMS, names.to_vec(), sum.clone());
        }
        sum
    }
}

/// Holds one answer more; where there are too many, the others go.
fn held<T>(answers: &mut BTreeMap<Vec<Name>, T>, most: usize, names: Vec<Name>, answer: T) {
    if answers.len() >= most {
        answers.clear();
    }
    answers.insert(names, answer);
}
