//! What was made of the observations so far: the posterior by geometry, and that by crops too.

use super::crops::{Crops, Reading};
use super::geometry::Geometry;
use crate::estimate::Dropped;
use crate::incremental::{Indefinite, Smoother, Update};
use crate::input::EstimateError;
use crate::orientation::Budget;
use crate::problem::Problem;
use crate::settings::OdometrySettings;
use crate::sighting::Sighting;
use std::collections::BTreeMap;
use vantage_dataset::{LandmarkSighting, Odometry};

/// Sightings, and the posteriors of them.
pub(super) struct Map<'m> {
    geometry: Geometry<'m>,
    crops: Option<Crops<'m>>,
    sightings: BTreeMap<usize, Vec<Sighting>>,
    landmarks: BTreeMap<usize, Vec<LandmarkSighting>>,
    pub dropped: Dropped,
}

impl<'m> Map<'m> {
    /// Empty, of a robot that reads crops as `reading` says.
    pub fn new(reading: Option<Reading<'m>>) -> Self {
        let (sightings, landmarks, dropped) = Default::default();
        Self { geometry: Geometry::new(), crops: reading.map(Crops::new), sightings, landmarks, dropped }
    }

    /// The posterior of all that is read.
    pub fn posterior(&self) -> &Smoother<'m> {
        &self.crops.as_ref().map_or(&self.geometry, |crops| &crops.posterior).smoother
    }

    /// A new pose.
    pub fn move_robot(&mut self, step: usize, odometry: &[Odometry], settings: &OdometrySettings) {
        self.geometry.move_robot(step, odometry, settings);
        if let Some(crops) = &mut self.crops {
            crops.posterior.move_robot(step, odometry, settings);
        }
    }

    /// Takes in a detection.
    pub fn see(&mut self, problem: &Problem<'_>, index: usize) -> Result<(), EstimateError> {
        let detection = &problem.observations.detections[index];
        let Some(sighting) = Sighting::new(&problem.observations.camera, index, detection) else {
            self.dropped.truncated += 1;
            return Ok(());
        };
        let sightings = self.sightings.entry(detection.track).or_default();
        sightings.push(sighting);
        self.geometry.see(problem, detection.track, sightings);
        if let Some(crops) = &mut self.crops {
            crops.see(problem, detection.track, sightings, &mut self.dropped)?;
        }
        Ok(())
    }

    /// Takes in a sighting of a landmark.
    pub fn see_landmark(&mut self, problem: &Problem<'_>, sighting: LandmarkSighting) {
        let sightings = self.landmarks.entry(sighting.landmark).or_default();
        sightings.push(sighting);
        let left_out = self.geometry.see_landmark(problem, sightings);
        self.dropped.landmark_behind_camera += match &mut self.crops {
            Some(crops) => crops.posterior.see_landmark(problem, sightings),
            None => left_out,
        };
    }

    /// Goes on to look for orientations; false where nothing is to be done.
    pub fn orient(&mut self, problem: &Problem<'_>, budget: Budget) -> Result<bool, EstimateError> {
        let Some(crops) = &mut self.crops else { return Ok(false) };
        crops.orient(problem, &self.sightings, self.geometry.values(), &mut self.dropped, budget)
    }

    /// Brings the posteriors up to date with what was added.
    pub fn update(&mut self) -> Result<Update, Indefinite> {
        let update = self.geometry.smoother.update()?;
        match &mut self.crops {
            Some(crops) => crops.posterior.smoother.update(),
            None => Ok(update),
        }
    }

    /// Looks for all orientations again, among all that was seen, and settles; `problem` is that of all boxes, where any are read.
    pub fn settle(
        &mut self,
        problem: Option<&Problem<'_>>,
        promise: f64,
        steps: usize,
    ) -> Result<Result<bool, Indefinite>, EstimateError> {
        let is_settled = self.geometry.smoother.settle(promise, steps);
        let (Some(problem), Some(crops)) = (problem, &mut self.crops) else { return Ok(is_settled) };
        let (sightings, geometry) = (&self.sightings, self.geometry.values());
        crops.look_again();
        while crops.orient(problem, sightings, geometry, &mut self.dropped, Budget::new(f64::INFINITY))? {}
        Ok(crops.settle(problem, sightings, (promise, steps)))
    }
}
