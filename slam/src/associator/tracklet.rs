//! Tracklets as far as they go, and what a hypothesis takes them to be.

use super::likeness::{Heading, Likeness};
use super::ratios::Part;
use super::scan::{Estimated, heading, pose};
use crate::sighting::Sighting;
use std::collections::BTreeMap;

/// The label of a tracklet that is of nothing; any other is the number of the tracklet that its object was first seen by.
pub(super) const NOTHING: usize = usize::MAX;

/// A tracklet, as far as it goes.
pub(super) struct Tracklet<R> {
    /// Step of the first sighting.
    pub began: usize,
    pub sightings: Vec<Sighting>,
    /// Of the robot's heading at the first sighting, as known then.
    pub heading_variance: f64,
    /// What was read of its crops at last, and the time before, and of how many sightings.
    pub readings: Vec<(usize, R)>,
}

/// Tracklets by their numbers.
pub(super) type Tracklets<L> = BTreeMap<usize, Tracklet<<L as Likeness>::Reading>>;

impl<R> Tracklet<R> {
    /// The step of its newest sighting.
    pub fn last(&self) -> usize {
        self.sightings.last().map_or(self.began, |sighting| sighting.step)
    }
}

/// What a hypothesis takes tracklets to be.
pub(super) struct Labels<'h> {
    pub hypothesis: &'h Estimated,
    by_tracklet: BTreeMap<usize, usize>,
}

impl<'h> Labels<'h> {
    pub fn of(hypothesis: &'h Estimated) -> Self {
        Self { hypothesis, by_tracklet: hypothesis.labels() }
    }

    /// The object of a tracklet; none of one that is of nothing.
    pub fn object(&self, tracklet: usize) -> Option<usize> {
        self.by_tracklet.get(&tracklet).copied().filter(|label| *label != NOTHING)
    }

    /// All objects.
    pub fn objects(&self) -> impl Iterator<Item = usize> {
        self.by_tracklet.iter().filter(|(number, label)| number == label).map(|(number, _)| *number)
    }

    /// The tracklets of an object.
    pub fn tracklets(&self, object: usize) -> impl Iterator<Item = usize> {
        self.by_tracklet.iter().filter(move |(_, label)| **label == object).map(|(number, _)| *number)
    }

    /// What was read of an object's tracklets, each with the heading of the frame that it was read in; of the one that is to be taken `back`, what
    /// was read before.
    pub fn parts<'t, R>(
        &self,
        tracklets: &'t BTreeMap<usize, Tracklet<R>>,
        object: usize,
        back: Option<usize>,
    ) -> Vec<Part<'t, R>> {
        let part = |number: usize| {
            let tracklet = tracklets.get(&number)?;
            let behind = 1 + usize::from(back == Some(number));
            let (sightings, reading) = &tracklet.readings[tracklet.readings.len().checked_sub(behind)?];
            let yaw = heading(&pose(self.hypothesis, tracklet.began)?);
            let heading = Heading { yaw, variance: tracklet.heading_variance };
            Some(Part::new(number, (*sightings, reading), heading))
        };
        self.tracklets(object).filter_map(part).collect()
    }
}
