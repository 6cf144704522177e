//! One episode, step by step, under all hypotheses.

use super::hypothesizing::AssociationSettings;
use super::likeness::{Heading, Likeness};
use super::sensing::Sensing;
use crate::association::{
    Addition, Alternative, AssociationError, Choice, Frame, Hypotheses, Hypothesis, LocalEstimator,
    SharedSmoother,
};
use crate::factor::Factor;
use crate::graph::Graph;
use crate::input::EstimateError;
use crate::problem::{Problem, add_bias, add_gauge, add_motion};
use crate::settings::{GeometrySettings, OdometrySettings};
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::rc::Rc;
use vantage_dataset::{Odometry, Pose, Tracklets};

/// The label of a tracklet that is of nothing; any other is the number of the tracklet that its object was first seen by.
const NOTHING: usize = usize::MAX;

pub(super) type Estimated = Hypothesis<SharedSmoother<'static>>;

/// A tracklet, as far as it goes.
struct Tracklet<R> {
    sightings: Vec<Sighting>,
    /// Of the robot's heading at the first sighting, as known then.
    heading_variance: f64,
    /// What was read of its crops, the newest last, and of how many sightings.
    readings: Vec<(usize, R)>,
}

/// What is believed so far.
pub(super) struct Scan<'a, L: Likeness> {
    odometry: &'a OdometrySettings,
    likeness: &'a L,
    /// Steps without a sighting after which a tracklet has come to its end.
    gap: usize,
    sensing: Sensing<'a>,
    tracklets: BTreeMap<usize, Tracklet<L::Reading>>,
    hypotheses: Hypotheses<SharedSmoother<'static>>,
}

impl<'a, L: Likeness> Scan<'a, L> {
    pub fn new(
        settings: &'a AssociationSettings,
        (odometry, geometry): (&'a OdometrySettings, &'a GeometrySettings),
        likeness: &'a L,
        seen: &'a Tracklets,
    ) -> Self {
        let hypotheses = Hypotheses::new(SharedSmoother::new(settings.thresholds), settings.limits);
        let sensing = Sensing { settings, geometry, observations: seen.observations() };
        Self { odometry, likeness, gap: seen.gap(), sensing, tracklets: BTreeMap::new(), hypotheses }
    }

    pub fn hypotheses(&self) -> &Hypotheses<SharedSmoother<'static>> {
        &self.hypotheses
    }

    fn problem(&self) -> Problem<'a> {
        Problem { observations: self.sensing.observations, settings: self.sensing.geometry }
    }

    /// Takes in a step: a motion, and sightings by their tracklets.
    pub fn advance(
        &mut self,
        step: usize,
        odometry: &[Odometry],
        seen: &BTreeMap<usize, Sighting>,
    ) -> Result<(), EstimateError> {
        let indefinite = |_: AssociationError| EstimateError::Indefinite { step };
        self.move_robot(step, odometry).map_err(indefinite)?;
        self.follow(seen).map_err(indefinite)?;
        self.meet(step, seen)?;
        for (&number, sighting) in seen {
            if let Some(tracklet) = self.tracklets.get_mut(&number) {
                tracklet.sightings.push(*sighting);
            }
        }
        for &number in seen.keys() {
            let sightings = self.tracklets.get(&number).map_or(0, |tracklet| tracklet.sightings.len());
            if sightings > 1 && sightings.is_power_of_two() {
                self.read(number, step)?;
            }
        }
        self.end(step)
    }

    /// All is brought up to date.
    pub fn finish(&mut self) -> Result<(), EstimateError> {
        let step = self.sensing.observations.steps().saturating_sub(1);
        let open: Vec<usize> = self.tracklets.keys().copied().collect();
        for number in open {
            self.close(number, step)?;
        }
        self.hypotheses.settle().map_err(|_| EstimateError::Indefinite { step })
    }

    fn move_robot(&mut self, step: usize, odometry: &[Odometry]) -> Result<(), AssociationError> {
        let settings = self.odometry;
        let mut fixed = Graph::default();
        let mut first = Values::default();
        if step == 0 {
            add_gauge(&mut fixed);
            add_bias(&mut fixed, &mut first, settings);
        }
        odometry.iter().for_each(|o| add_motion(&mut fixed, o, settings));
        let factors: Vec<Rc<dyn Factor>> = fixed.into_factors().map(Rc::from).collect();
        self.hypotheses.observe(|hypothesis| {
            let at = |step: usize| pose(hypothesis, step);
            let reached = odometry.iter().find_map(|o| Some(at(o.from)? * o.robot_from_robot));
            let mut fresh = vec![(Key::Robot(step), Value::Pose(reached.unwrap_or_else(Pose::identity)))];
            fresh.extend(first.iter().map(|(key, value)| (key, value.clone())));
            Addition { factors: factors.clone(), fresh }
        })
    }

    /// Tracklets that go on: of what they were of.
    fn follow(&mut self, seen: &BTreeMap<usize, Sighting>) -> Result<(), AssociationError> {
        let going: Vec<(usize, &Sighting)> = (seen.iter())
            .filter(|(number, _)| self.tracklets.contains_key(number))
            .map(|(number, sighting)| (*number, sighting))
            .collect();
        if going.is_empty() {
            return Ok(());
        }
        let sensing = self.sensing;
        self.hypotheses.observe(|hypothesis| {
            let of = going.iter().filter_map(|&(number, sighting)| {
                let label = hypothesis.label(number).filter(|label| *label != NOTHING)?;
                Some(sensing.bearing(label, sighting))
            });
            of.fold(Addition::default(), Addition::with)
        })?;
        self.hypotheses.choose(|hypothesis| {
            let of = |&(number, sighting): &(usize, &Sighting)| match hypothesis.label(number) {
                Some(NOTHING) => libm::log(sensing.settings.clutter),
                _ => sensing.log_normalizer(sighting),
            };
            Frame { choices: Vec::new(), log_weight: going.iter().map(of).sum() }
        })
    }

    /// Tracklets that begin: of an object that is known and not in view otherwise, of a new one, or of nothing.
    fn meet(&mut self, step: usize, seen: &BTreeMap<usize, Sighting>) -> Result<(), EstimateError> {
        let mut begun = Vec::new();
        for (&number, sighting) in seen.iter().filter(|(number, _)| !self.tracklets.contains_key(number)) {
            begun.push((number, sighting, self.first_reading(sighting)?));
        }
        if begun.is_empty() {
            return Ok(());
        }
        let is_live = |tracklet: &&Tracklet<L::Reading>| {
            tracklet.sightings.last().is_some_and(|last| last.step + self.gap >= step)
        };
        let live: Vec<usize> = (self.tracklets.iter())
            .filter(|(_, tracklet)| is_live(tracklet))
            .map(|(number, _)| *number)
            .collect();
        self.hypotheses.settle().map_err(|_| EstimateError::Indefinite { step })?;
        let variance = self.heading_variance(step);
        let (sensing, tracklets, likeness) = (self.sensing, &self.tracklets, self.likeness);
        let chosen = self.hypotheses.choose(|hypothesis| {
            let taken: Vec<usize> = live.iter().filter_map(|number| hypothesis.label(*number)).collect();
            let is_free =
                |number: &&usize| hypothesis.label(**number) == Some(**number) && !taken.contains(*number);
            let objects: Vec<usize> = tracklets.keys().filter(is_free).copied().collect();
            let choices = begun.iter().map(|(number, sighting, reading)| {
                let log_normal = sensing.log_normalizer(sighting);
                let mut near: Vec<(f64, usize)> = (objects.iter())
                    .filter_map(|&object| Some((sensing.off(hypothesis, object, sighting)?, object)))
                    .collect();
                near.sort_by(|a, b| a.0.total_cmp(&b.0));
                let yaw = pose(hypothesis, step).map_or(0.0, |pose| heading(&pose));
                let heading = Heading { yaw, variance };
                let near = near.into_iter().take(sensing.settings.candidates);
                let of_known = near.map(|(_, object)| {
                    let mut parts = parts(tracklets, hypothesis, object, None);
                    let before = likeness.log_ratio(&parts);
                    parts.extend(reading.as_ref().map(|reading| (reading, heading)));
                    Alternative {
                        label: object,
                        addition: Addition::default().with(sensing.bearing(object, sighting)),
                        log_weight: log_normal + likeness.log_ratio(&parts) - before,
                        claims: Some(object),
                    }
                });
                let mut alternatives: Vec<Alternative<'static>> = of_known.collect();
                alternatives.extend(sensing.new_object(hypothesis, *number, sighting));
                alternatives.push(Alternative {
                    label: NOTHING,
                    addition: Addition::default(),
                    log_weight: libm::log(sensing.settings.clutter),
                    claims: None,
                });
                Choice { number: *number, alternatives }
            });
            Frame { choices: choices.collect(), log_weight: 0.0 }
        });
        chosen.map_err(|_| EstimateError::Indefinite { step })?;
        for (number, _, reading) in begun {
            let readings = reading.map(|reading| (1, reading)).into_iter().collect();
            let tracklet = Tracklet { sightings: Vec::new(), heading_variance: variance, readings };
            self.tracklets.insert(number, tracklet);
        }
        Ok(())
    }

    /// Of the robot's heading, by the likeliest hypothesis.
    fn heading_variance(&self, step: usize) -> f64 {
        let key = Key::Robot(step);
        let joint = self.hypotheses.best().and_then(|best| best.estimator().joint(&[key]));
        let covariance = joint.and_then(|joint| joint.covariance(key));
        // The robot stands upright but for little: its z axis is the world's.
        covariance.map_or(0.0, |covariance| covariance[(2, 2)].max(0.0))
    }

    /// What the first sighting of something shows, at the depth that its box tells.
    fn first_reading(&self, sighting: &Sighting) -> Result<Option<L::Reading>, EstimateError> {
        let best = self.hypotheses.best();
        let Some(robot) = best.and_then(|best| pose(best, sighting.step)) else { return Ok(None) };
        let level = level(&robot);
        let tilted = level.inv_mul(&robot);
        let there = tilted * self.sensing.observations.robot_from_camera * self.sensing.first_place(sighting);
        let mut values = Values::default();
        values.insert(Key::Object(0), Value::Point(there.coords));
        values.insert(Key::Robot(sighting.step), Value::Pose(tilted));
        Ok(Some(self.likeness.read(&self.problem(), &values, std::slice::from_ref(sighting))?))
    }

    /// Weighs hypotheses by what a tracklet's crops look like, as far as it goes.
    fn read(&mut self, number: usize, step: usize) -> Result<(), EstimateError> {
        let Some(reading) = self.reading(number)? else { return Ok(()) };
        let Some(tracklet) = self.tracklets.get_mut(&number) else { return Ok(()) };
        tracklet.readings.push((tracklet.sightings.len(), reading));
        let (tracklets, likeness) = (&self.tracklets, self.likeness);
        let frame = |hypothesis: &Estimated| {
            let label = hypothesis.label(number).filter(|label| *label != NOTHING);
            let log_weight = label.map_or(0.0, |label| {
                let now = likeness.log_ratio(&parts(tracklets, hypothesis, label, None));
                now - likeness.log_ratio(&parts(tracklets, hypothesis, label, Some(number)))
            });
            Frame { choices: Vec::new(), log_weight }
        };
        self.hypotheses.choose(frame).map_err(|_| EstimateError::Indefinite { step })
    }

    /// A tracklet's reading by the likeliest hypothesis that has it of something.
    fn reading(&self, number: usize) -> Result<Option<L::Reading>, EstimateError> {
        let Some(Tracklet { sightings, .. }) = self.tracklets.get(&number) else { return Ok(None) };
        let Some(first) = sightings.first() else { return Ok(None) };
        for hypothesis in self.hypotheses.all() {
            let label = hypothesis.label(number).filter(|label| *label != NOTHING);
            let place = label.and_then(|label| hypothesis.estimator().value(Key::Object(label)));
            let (Some(place), Some(origin)) =
                (place.and_then(|v| v.position()), pose(hypothesis, first.step))
            else {
                continue;
            };
            let level = level(&origin);
            let mut values = Values::default();
            let there = level.inverse_transform_point(&place.into()).coords;
            values.insert(Key::Object(0), Value::Point(there));
            for sighting in sightings {
                if let Some(pose) = pose(hypothesis, sighting.step) {
                    values.insert(Key::Robot(sighting.step), Value::Pose(level.inv_mul(&pose)));
                }
            }
            return Ok(Some(self.likeness.read(&self.problem(), &values, sightings)?));
        }
        Ok(None)
    }

    /// Tracklets that have just come to their end.
    fn end(&mut self, step: usize) -> Result<(), EstimateError> {
        let gap = self.gap;
        let ended: Vec<usize> = (self.tracklets.iter())
            .filter(|(_, t)| t.sightings.last().is_some_and(|s| s.step + gap + 1 == step))
            .map(|(number, _)| *number)
            .collect();
        ended.into_iter().try_for_each(|number| self.close(number, step))
    }

    /// A tracklet is read to its end; one of a single sighting is seldom of an object.
    fn close(&mut self, number: usize, step: usize) -> Result<(), EstimateError> {
        let Some(tracklet) = self.tracklets.get(&number) else { return Ok(()) };
        let (sightings, read) = (tracklet.sightings.len(), tracklet.readings.last().map(|(n, _)| *n));
        if sightings == 1 && self.gap > 0 {
            let log_single = libm::log(self.sensing.settings.single);
            let frame = |hypothesis: &Estimated| {
                let is_object = hypothesis.label(number) != Some(NOTHING);
                Frame { choices: Vec::new(), log_weight: if is_object { log_single } else { 0.0 } }
            };
            self.hypotheses.choose(frame).map_err(|_| EstimateError::Indefinite { step })?;
        }
        if read.is_some_and(|read| read < sightings) { self.read(number, step) } else { Ok(()) }
    }
}

/// The objects of all tracklets under a hypothesis; none of one that is of nothing, or was never seen whole.
pub(super) fn objects(hypothesis: &Estimated, count: usize) -> Vec<Option<usize>> {
    (0..count).map(|number| hypothesis.label(number).filter(|label| *label != NOTHING)).collect()
}

pub(super) fn pose(hypothesis: &Estimated, step: usize) -> Option<Pose> {
    match hypothesis.estimator().value(Key::Robot(step))? {
        Value::Pose(pose) => Some(pose),
        _ => None,
    }
}

/// What was read of an object's tracklets, each with the heading of the frame that it was read in; of the one that is to be taken `back`, what
/// was read before.
fn parts<'t, R>(
    tracklets: &'t BTreeMap<usize, Tracklet<R>>,
    hypothesis: &Estimated,
    object: usize,
    back: Option<usize>,
) -> Vec<(&'t R, Heading)> {
    let of_object = tracklets.iter().filter(|(number, _)| hypothesis.label(**number) == Some(object));
    let part = |(number, tracklet): (&usize, &'t Tracklet<R>)| {
        let behind = 1 + usize::from(back == Some(*number));
        let (_, reading) = &tracklet.readings[tracklet.readings.len().checked_sub(behind)?];
        let yaw = heading(&pose(hypothesis, tracklet.sightings.first()?.step)?);
        Some((reading, Heading { yaw, variance: tracklet.heading_variance }))
    };
    of_object.filter_map(part).collect()
}

/// A pose upright: of its rotation the heading alone.
fn level(pose: &Pose) -> Pose {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading(pose));
    Pose::from_parts(pose.translation, rotation)
}

/// Of a pose about the world's z axis.
fn heading(pose: &Pose) -> f64 {
    let forward = pose.rotation * Vector3::x();
    libm::atan2(forward.y, forward.x)
}
