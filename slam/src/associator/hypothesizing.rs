//! Hypotheses over the objects of tracklets, weighted by geometry and by what crops look like.

use super::likeness::Likeness;
use super::scan::Scan;
use super::tracklet::Labels;
use super::{Association, Associator, WeightedPartition};
use crate::association::{Limits, Thresholds};
use crate::input::{EstimateError, check_observations};
use crate::settings::{GeometrySettings, OdometrySettings, Settings};
use crate::sighting::Sighting;
use std::collections::BTreeMap;
use std::time::Instant;
use vantage_dataset::Tracklets;

/// What is likely before anything is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssociationSettings {
    /// How many hypotheses are kept.
    pub limits: Limits,
    /// How exactly each is solved.
    pub thresholds: Thresholds,
    /// Expected objects a cubic metre.
    pub density: f64,
    /// Expected detections of nothing, a steradian and a step.
    pub clutter: f64,
    /// Probability that a tracklet of an object has one sighting, where detections are joined.
    pub single: f64,
    /// Median diameter of an object, metres, and its spread as a share.
    pub size: f64,
    /// See `size`.
    pub size_spread: f64,
    /// Known objects that a tracklet may be of, the nearest by angle.
    pub candidates: usize,
    /// Squared Mahalanobis distance of a bearing within which a tracklet is of the nearest object that is known, and else of a new one, one tracklet
    /// after the other; all ways are weighed where there is none.
    pub gate: Option<f64>,
}

impl Default for AssociationSettings {
    fn default() -> Self {
        Self {
            limits: Limits { hypotheses: 32, least_weight: 1e-4, merging: None },
            thresholds: Thresholds::default(),
            density: 0.1,
            clutter: 1e-3,
            single: 0.03,
            size: 0.25,
            size_spread: 0.4,
            candidates: 6,
            gate: None,
        }
    }
}

/// Hypotheses by a likeness of crops.
pub struct Hypothesizing<L> {
    settings: AssociationSettings,
    odometry: OdometrySettings,
    geometry: GeometrySettings,
    likeness: L,
}

impl<L: Likeness> Hypothesizing<L> {
    /// With an estimator's settings of odometry and boxes.
    pub fn new(estimator: &Settings, settings: AssociationSettings, likeness: L) -> Self {
        Self { settings, odometry: estimator.odometry, geometry: estimator.geometry, likeness }
    }
}

impl<L: Likeness> Associator for Hypothesizing<L> {
    fn associate(&self, seen: &Tracklets) -> Result<Association, EstimateError> {
        let observations = seen.observations();
        check_observations(observations, &self.odometry)?;
        let mut by_step: Vec<BTreeMap<usize, Sighting>> = vec![BTreeMap::new(); observations.steps()];
        for (index, detection) in observations.detections.iter().enumerate() {
            if let Some(sighting) = Sighting::new(&observations.camera, index, detection) {
                by_step[detection.step].insert(detection.track, sighting);
            }
        }
        let mut scan = Scan::new(&self.settings, (&self.odometry, &self.geometry), &self.likeness, seen);
        let mut times = Vec::with_capacity(by_step.len());
        for (step, sightings) in by_step.iter().enumerate() {
            let start = Instant::now();
            let odometry: Vec<_> =
                observations.odometry.iter().filter(|o| o.from.max(o.to) == step).cloned().collect();
            scan.advance(step, &odometry, sightings)?;
            times.push(start.elapsed());
        }
        scan.finish()?;
        let all = scan.hypotheses().all().iter();
        let objects = |labels: Labels<'_>| (0..seen.count()).map(|number| labels.object(number)).collect();
        let partitions =
            all.map(|h| WeightedPartition { weight: h.weight(), objects: objects(Labels::of(h)) });
        Ok(Association { hypotheses: added_up(partitions), times, places: scan.places() })
    }
}

/// Each partition once, the likeliest first: hypotheses may tell one with several estimates.
fn added_up(all: impl Iterator<Item = WeightedPartition>) -> Vec<WeightedPartition> {
    let mut partitions: Vec<WeightedPartition> = Vec::new();
    for one in all {
        match partitions.iter_mut().find(|other| other.objects == one.objects) {
            Some(other) => other.weight += one.weight,
            None => partitions.push(one),
        }
    }
    partitions.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    partitions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_of_one_partition_add_up() {
        let of = |weight, object| WeightedPartition { weight, objects: vec![Some(0), object] };
        let all = [of(0.4, None), of(0.35, Some(0)), of(0.25, Some(0))];
        assert_eq!(added_up(all.into_iter()), [of(0.6, Some(0)), of(0.4, None)]);
    }
}
