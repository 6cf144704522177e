//! What was made of the observations so far: the posterior by geometry, and that by crops too.

use super::crops::{Crops, Reading};
use super::growing_posterior::GrowingPosterior;
use super::relocation::Lost;
use super::sighted::Sighted;
use crate::incremental::{Indefinite, Smoother, Update};
use crate::input::EstimateError;
use crate::orientation::Budget;
use crate::problem::Problem;
use crate::settings::OdometrySettings;
use crate::sighting::Sighting;
use vantage_dataset::{LandmarkSighting, Odometry};
use vantage_model::AnswerError;

/// Sightings, and the posteriors of them.
pub(super) struct Map<'m> {
    geometry: GrowingPosterior<'m>,
    crops: Option<Crops<'m>>,
    sighted: Sighted,
}

impl<'m> Map<'m> {
    /// Empty, of a robot that reads crops as `reading` says.
    pub fn new(reading: Option<Reading<'m>>) -> Self {
        Self {
            geometry: GrowingPosterior::new(),
            crops: reading.map(Crops::new),
            sighted: Sighted::default(),
        }
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

    /// Takes in a detection, unless it is truncated.
    pub fn see(&mut self, problem: &Problem<'_>, index: usize) -> Result<(), AnswerError> {
        let detection = &problem.observations.detections[index];
        let Some(sighting) = Sighting::new(&problem.observations.camera, index, detection) else {
            return Ok(());
        };
        let sightings = self.sighted.objects.entry(detection.track).or_default();
        sightings.push(sighting);
        self.geometry.see(problem, detection.track, sightings);
        match &mut self.crops {
            Some(crops) => crops.see(problem, detection.track, sightings, &self.geometry),
            None => Ok(()),
        }
    }

    /// Takes in a sighting of a landmark.
    pub fn see_landmark(&mut self, problem: &Problem<'_>, sighting: LandmarkSighting) {
        let sightings = self.sighted.landmarks.entry(sighting.landmark).or_default();
        sightings.push(sighting);
        self.geometry.see_landmark(problem, sightings);
        if let Some(crops) = &mut self.crops {
            crops.posterior.see_landmark(problem, sightings);
        }
    }

    /// Goes on to look for orientations, within a budget.
    pub fn orient(&mut self, problem: &Problem<'_>, budget: Budget) -> Result<(), AnswerError> {
        if let Some(crops) = &mut self.crops {
            crops.orient(problem, &self.sighted.objects, &self.geometry, budget)?;
        }
        Ok(())
    }

    /// Brings the posteriors up to date with what was added.
    pub fn update(&mut self) -> Result<Update, Indefinite> {
        let update = self.geometry.smoother.update()?;
        match &mut self.crops {
            Some(crops) => crops.posterior.smoother.update(),
            None => Ok(update),
        }
    }

    /// Looks for where a robot is that was set down and sees few objects it knows. Whether the posterior of all that is read is settled then; `None` where it
    /// was left as it is.
    pub fn relocate(&mut self, problem: &Problem<'_>) -> Result<Option<bool>, Indefinite> {
        let smoother = &mut self.geometry.smoother;
        let Some(lost) = Lost::new(problem, &self.sighted, smoother.values()) else { return Ok(None) };
        let settled = lost.relocate(problem, smoother)?;
        match &mut self.crops {
            Some(crops) => lost.relocate(problem, &mut crops.posterior.smoother),
            None => Ok(settled),
        }
    }

    /// Settles geometry, with what has a place only there, and crops from there; `problem` is that of all boxes, where any are read.
    pub fn settle(
        &mut self,
        problem: Option<&Problem<'_>>,
        (promise, iterations): (f64, usize),
        indefinite: impl Fn(Indefinite) -> EstimateError,
    ) -> Result<bool, EstimateError> {
        let Self { geometry, crops, sighted } = self;
        let mut is_settled = geometry.smoother.settle(promise, iterations).map_err(&indefinite)?;
        let Some(problem) = problem else { return Ok(is_settled) };
        while geometry.place_more(problem, sighted) {
            is_settled = geometry.smoother.settle(promise, iterations).map_err(&indefinite)?;
        }
        let Some(crops) = crops else { return Ok(is_settled) };
        let settled = crops.settle(problem, sighted, geometry, (promise, iterations))?;
        Ok(settled.map_err(indefinite)? && is_settled)
    }
}
