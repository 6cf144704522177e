//! Ratios of likelihoods that hypotheses have in common, each worked out once.

use super::likeness::{Heading, Likeness};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Headings are told in so many steps of a turn.
const STEPS: f64 = 48.0;
/// Ratios that are held; what hypotheses ask for next is among the newest.
const HELD: usize = 20_000;

/// What was read of a tracklet, in a frame of some heading.
pub(super) struct Part<'t, R> {
    /// The tracklet, how many of its sightings were read, and the heading in steps.
    name: (usize, usize, i64),
    reading: &'t R,
    variance: f64,
}

impl<'t, R> Part<'t, R> {
    /// What was read of so many sightings of a tracklet.
    pub fn new(tracklet: usize, (sightings, reading): (usize, &'t R), heading: Heading) -> Self {
        let steps = libm::round(heading.yaw / (2.0 * PI) * STEPS) as i64;
        Self { name: (tracklet, sightings, steps), reading, variance: heading.variance }
    }
}

/// A likeness that does not answer twice.
pub(super) struct Ratios<'a, L> {
    likeness: &'a L,
    held: RefCell<BTreeMap<Vec<(usize, usize, i64)>, f64>>,
}

impl<'a, L: Likeness> Ratios<'a, L> {
    pub fn new(likeness: &'a L) -> Self {
        Self { likeness, held: RefCell::default() }
    }

    pub fn likeness(&self) -> &'a L {
        self.likeness
    }

    /// [`Likeness::log_ratio`] of parts. Those of one name have one variance.
    pub fn log_ratio(&self, parts: &[Part<'_, L::Reading>]) -> f64 {
        let names: Vec<_> = parts.iter().map(|part| part.name).collect();
        if let Some(ratio) = self.held.borrow().get(&names) {
            return *ratio;
        }
        let heading = |part: &Part<'_, L::Reading>| Heading {
            yaw: part.name.2 as f64 * 2.0 * PI / STEPS,
            variance: part.variance,
        };
        let readings: Vec<_> = parts.iter().map(|part| (part.reading, heading(part))).collect();
        let ratio = self.likeness.log_ratio(&readings);
        let mut held = self.held.borrow_mut();
        if held.len() >= HELD {
            held.clear();
        }
        held.insert(names, ratio);
        ratio
    }
}
