//! What is read of tracklets as they go on.

use super::likeness::Likeness;
use super::scan::{Estimated, Scan, level, pose};
use super::tracklet::{Labels, Tracklet};
use super::view::own_frame;
use crate::association::{Frame, LocalEstimator};
use crate::input::EstimateError;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};

impl<L: Likeness> Scan<'_, L> {
    /// Of the robot's heading, by the likeliest hypothesis.
    pub(super) fn heading_variance(&self, step: usize) -> f64 {
        let key = Key::Robot(step);
        let joint = self.hypotheses.best().and_then(|best| best.estimator().joint(&[key]));
        let covariance = joint.and_then(|joint| joint.covariance(key));
        // The robot stands upright but for little: its z axis is the world's.
        covariance.map_or(0.0, |covariance| covariance[(2, 2)].max(0.0))
    }

    /// What the first sighting of something shows, at the depth that its box tells.
    pub(super) fn first_reading(&self, sighting: &Sighting) -> Result<Option<L::Reading>, EstimateError> {
        let best = self.hypotheses.best();
        let Some(robot) = best.and_then(|best| pose(best, sighting.step)) else { return Ok(None) };
        let level = level(&robot);
        let tilted = level.inv_mul(&robot);
        let there = tilted * self.sensing.observations.robot_from_camera * self.sensing.first_place(sighting);
        let mut values = Values::default();
        values.insert(Key::Object(0), Value::Point(there.coords));
        values.insert(Key::Robot(sighting.step), Value::Pose(tilted));
        Ok(Some(self.ratios.likeness().read(&self.problem(), &values, std::slice::from_ref(sighting))?))
    }

    /// Weighs hypotheses by what a tracklet's crops look like, as far as it goes.
    pub(super) fn read(&mut self, number: usize, step: usize) -> Result<(), EstimateError> {
        let Some(reading) = self.reading(number)? else { return Ok(()) };
        let Some(tracklet) = self.tracklets.get_mut(&number) else { return Ok(()) };
        // The one before is taken back below.
        tracklet.readings.drain(..tracklet.readings.len().saturating_sub(1));
        tracklet.readings.push((tracklet.sightings.len(), reading));
        let (tracklets, ratios) = (&self.tracklets, &self.ratios);
        let frame = |hypothesis: &Estimated| {
            let labels = Labels::of(hypothesis);
            let log_weight = labels.object(number).map_or(0.0, |object| {
                let now = ratios.log_ratio(&labels.parts(tracklets, object, None));
                now - ratios.log_ratio(&labels.parts(tracklets, object, Some(number)))
            });
            Frame { choices: Vec::new(), log_weight }
        };
        self.hypotheses.choose(frame).map_err(|error| EstimateError::Association { step, error })
    }

    /// A tracklet's reading by the likeliest hypothesis that has it of something.
    fn reading(&self, number: usize) -> Result<Option<L::Reading>, EstimateError> {
        let Some(Tracklet { sightings, .. }) = self.tracklets.get(&number) else { return Ok(None) };
        for hypothesis in self.hypotheses.all() {
            let object = Labels::of(hypothesis).object(number);
            let place = object.and_then(|object| hypothesis.estimator().value(Key::Object(object)));
            let Some(place) = place.and_then(|value| value.position()) else { continue };
            let Some(values) = own_frame(sightings, place, |step| pose(hypothesis, step)) else { continue };
            return Ok(Some(self.ratios.likeness().read(&self.problem(), &values, sightings)?));
        }
        Ok(None)
    }

    /// Tracklets that have just come to their end: one of a single sighting is seldom of an object.
    pub(super) fn end(&mut self, step: usize) -> Result<(), EstimateError> {
        let gap = self.gap;
        let ended: Vec<usize> = (self.tracklets.iter())
            .filter(|(_, tracklet)| tracklet.last() + gap + 1 == step)
            .map(|(number, _)| *number)
            .collect();
        for number in ended {
            if gap > 0 && self.tracklets[&number].sightings.len() == 1 {
                let log_single = libm::log(self.sensing.settings.single);
                let frame = |hypothesis: &Estimated| {
                    let is_object = Labels::of(hypothesis).object(number).is_some();
                    Frame { choices: Vec::new(), log_weight: if is_object { log_single } else { 0.0 } }
                };
                self.hypotheses.choose(frame).map_err(|error| EstimateError::Association { step, error })?;
            }
            self.read_rest(number, step)?;
        }
        Ok(())
    }

    /// Reads what was not read of a tracklet.
    pub(super) fn read_rest(&mut self, number: usize, step: usize) -> Result<(), EstimateError> {
        let Some(tracklet) = self.tracklets.get(&number) else { return Ok(()) };
        let read = tracklet.readings.last().map(|(sightings, _)| *sightings);
        if read.is_some_and(|read| read < tracklet.sightings.len()) {
            self.read(number, step)
        } else {
            Ok(())
        }
    }
}
