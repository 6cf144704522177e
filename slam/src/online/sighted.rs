//! What was seen, by track and landmark.

use crate::sighting::Sighting;
use std::collections::BTreeMap;
use vantage_dataset::LandmarkSighting;

/// Sightings in the order of the steps.
#[derive(Default)]
pub(super) struct Sighted {
    /// By track.
    pub objects: BTreeMap<usize, Vec<Sighting>>,
    /// By landmark.
    pub landmarks: BTreeMap<usize, Vec<LandmarkSighting>>,
}
