//! A sensor that sees point objects in a sector before the robot, some of them, and some that are not there.

use super::{Motion, PlanarPoint, landmark, log_normalizer, pose};
use crate::association::{Addition, Alternative, Choice, Frame, Hypothesis, SharedSmoother};
use crate::variable::{Key, Value};
use nalgebra::{DVector, Matrix2, Vector2};
use std::collections::BTreeMap;

/// What is known of detections before any is had.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// How far it sees, metres.
    pub range: f64,
    /// How far to either side, radians.
    pub half_angle: f64,
    /// Square root of the information of a detection's place in the robot's frame.
    pub sqrt_information: Matrix2<f64>,
    /// Probability that an object in view is detected, below 1.
    pub detection: f64,
    /// Expected number of false detections at a time, anywhere in view.
    pub clutter: f64,
    /// Expected number of objects a square metre.
    pub density: f64,
    /// Number of classes, all as likely; a detection tells the right one.
    pub classes: usize,
    /// Nearest known objects that a detection may be of.
    pub candidates: usize,
}

/// Something seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Its number, unlike any other's.
    pub number: usize,
    /// Its place in the robot's frame, metres.
    pub measured: Vector2<f64>,
    /// Its class.
    pub class: usize,
}

/// The label of a false detection; any other is the number of the detection that an object was first seen by.
pub const CLUTTER: usize = usize::MAX;

/// Views that a place may have been in without being seen, beyond which no more are counted: the pose is not known so well.
const COUNTED_VIEWS: usize = 2;
/// How near the border of its view the sensor may or may not see, metres.
const BORDER: f64 = 0.5;

/// Views of a track that say where undetected objects are unlikely.
pub struct Sensing {
    sensor: Sensor,
    /// Class by the number of a detection.
    classes: BTreeMap<usize, usize>,
    /// Poses that looked.
    views: Vec<usize>,
}

impl Sensing {
    /// Before the first view.
    pub fn new(sensor: Sensor) -> Self {
        Self { sensor, classes: BTreeMap::new(), views: Vec::new() }
    }

    /// Takes note that a pose looked, with what it saw; to be called once a choice between the alternatives of [`Sensing::frame`] is made.
    pub fn look(&mut self, step: usize, detections: &[Detection]) {
        self.views.push(step);
        self.classes.extend(detections.iter().map(|detection| (detection.number, detection.class)));
    }

    /// What the detections at a step may be under a hypothesis: one of its objects, a new one, or none.
    ///
    /// The weights are those of Poisson processes of objects and of clutter, and of independent detection: an object assigned counts `P_D`, one in
    /// view that is not `1 - P_D`, a new one the density of objects thinned by the views in which it was not seen, clutter its density.
    pub fn frame(
        &self,
        hypothesis: &Hypothesis<SharedSmoother<'static>>,
        step: usize,
        detections: &[Detection],
    ) -> Frame<'static> {
        let estimator = hypothesis.estimator();
        let Some(robot) = pose(estimator, step) else { return Frame::default() };
        let sensor = &self.sensor;
        let known: Vec<Known> = (self.classes.iter())
            .filter_map(|(&number, &class)| {
                let there = robot.seen(landmark(estimator, number)?);
                Some(Known { number, class, there })
            })
            .collect();
        let is_missed = |object: &Known| sensor.depth(object.there) > BORDER;
        let log_missed = libm::log(1.0 - sensor.detection);
        let log_weight = log_missed * known.iter().filter(|object| is_missed(object)).count() as f64;
        let log_normal = log_normalizer(&sensor.sqrt_information);
        let log_clutter = libm::log(sensor.clutter / sensor.area() / sensor.classes as f64);
        let choices = detections.iter().map(|detection| {
            let addition = |number: usize| {
                let (from, to) = (Key::Robot(step), Key::Landmark(number));
                Addition::default().with(PlanarPoint::new(
                    from,
                    to,
                    detection.measured,
                    sensor.sqrt_information,
                ))
            };
            let mut candidates: Vec<&Known> =
                known.iter().filter(|object| object.class == detection.class).collect();
            let distance = |object: &&Known| (object.there - detection.measured).norm();
            candidates.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
            candidates.truncate(sensor.candidates);
            let mut alternatives: Vec<Alternative<'static>> = (candidates.into_iter())
                .map(|object| Alternative {
                    label: object.number,
                    addition: addition(object.number),
                    log_weight: log_normal + libm::log(sensor.detection)
                        - if is_missed(object) { log_missed } else { 0.0 },
                    claims: Some(object.number),
                })
                .collect();
            let place = robot.point(detection.measured);
            let first = Value::Vector(DVector::from_column_slice(place.as_slice()));
            let thinned = self.log_unseen(estimator, place) + libm::log(sensor.density * sensor.detection);
            alternatives.push(Alternative {
                label: detection.number,
                addition: addition(detection.number).with_variable(Key::Landmark(detection.number), first),
                log_weight: log_normal + thinned - libm::log(sensor.classes as f64),
                claims: None,
            });
            if sensor.clutter > 0.0 {
                let addition = Addition::default();
                alternatives.push(Alternative {
                    label: CLUTTER,
                    addition,
                    log_weight: log_clutter,
                    claims: None,
                });
            }
            Choice { number: detection.number, alternatives }
        });
        Frame { choices: choices.collect(), log_weight }
    }

    /// `log` of the probability that an object at a place was in no view so far, or not detected.
    fn log_unseen(&self, estimator: &SharedSmoother<'static>, place: Vector2<f64>) -> f64 {
        let poses = self.views.iter().filter_map(|&step| pose(estimator, step));
        let seen = poses.filter(|pose| self.sensor.depth(pose.seen(place)) > BORDER);
        let counted = seen.take(COUNTED_VIEWS).count() as f64;
        counted * libm::log(1.0 - self.sensor.detection)
    }
}

struct Known {
    number: usize,
    class: usize,
    /// In the robot's frame.
    there: Vector2<f64>,
}

impl Sensor {
    /// Of its view, square metres.
    pub fn area(&self) -> f64 {
        self.half_angle * self.range * self.range
    }

    /// How far inside its view a place in the robot's frame is, metres; negative outside.
    pub fn depth(&self, there: Vector2<f64>) -> f64 {
        let range = there.norm();
        let off = self.half_angle - libm::atan2(there.y, there.x).abs();
        let to_side = if self.half_angle >= std::f64::consts::PI { f64::INFINITY } else { range * off };
        (self.range - range).min(to_side)
    }

    /// Whether a place in the world is in view from a pose.
    pub fn sees(&self, robot: Motion, place: Vector2<f64>) -> bool {
        self.depth(robot.seen(place)) > 0.0
    }
}
