//! Planar SLAM with measurements that may be taken in several ways.

use super::{Motion, PlanarBetween, PlanarPoint, PlanarPrior, log_normalizer, whitening};
use crate::association::{
    Addition, Alternative, AssociationError, Choice, Frame, Hypotheses, Limits, LocalEstimator,
    SharedSmoother, Thresholds,
};
use crate::variable::{Key, Value};
use nalgebra::{DVector, Matrix2, Matrix3, Vector2};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Deviations, and what is likely before anything is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarNoise {
    /// Of a motion: forward and left, metres, and heading, radians.
    pub motion: [f64; 3],
    /// Of the first pose about the origin.
    pub start: [f64; 3],
    /// Of a landmark in the robot's frame, metres.
    pub point: [f64; 2],
    /// Radius of what is measured from a pose, metres: false measurements and new landmarks are as likely anywhere in it.
    pub reach: f64,
    /// Probability that a measurement which may be false is.
    pub false_share: f64,
}

/// A motion that was measured between two poses.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionMeasurement {
    /// From this pose.
    pub from: usize,
    /// To this one, which may be new.
    pub to: usize,
    /// It is one of these, all as likely.
    pub modes: Vec<Motion>,
    /// Whether it may be none of them.
    pub is_detachable: bool,
}

/// A landmark that was measured from a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMeasurement {
    /// It is one of these, all as likely; they may be new.
    pub candidates: Vec<usize>,
    /// Where it was seen, in the robot's frame, metres.
    pub measured: Vector2<f64>,
}

/// Poses and landmarks under all hypotheses that are kept. Alternatives are labelled by their place in the measurement; that it is false, by the
/// number after the last.
pub struct PlanarSlam {
    hypotheses: Hypotheses<SharedSmoother<'static>>,
    noise: PlanarNoise,
    poses: BTreeSet<usize>,
    landmarks: BTreeSet<usize>,
    motion_information: Matrix3<f64>,
    point_information: Matrix2<f64>,
}

impl PlanarSlam {
    /// A robot at the origin, as pose 0.
    ///
    /// # Errors
    /// None that sound deviations give.
    pub fn new(noise: PlanarNoise, limits: Limits, thresholds: Thresholds) -> Result<Self, AssociationError> {
        let mut hypotheses = Hypotheses::new(SharedSmoother::new(thresholds), limits);
        let origin = Motion::new(0.0, 0.0, 0.0);
        hypotheses.observe(|_| {
            let prior = PlanarPrior::new(Key::Robot(0), origin, whitening(noise.start));
            Addition::default().with_variable(Key::Robot(0), origin.to_value()).with(prior)
        })?;
        Ok(Self {
            hypotheses,
            noise,
            poses: BTreeSet::from([0]),
            landmarks: BTreeSet::new(),
            motion_information: whitening(noise.motion),
            point_information: whitening(noise.point),
        })
    }

    /// All that is believed.
    pub fn hypotheses(&self) -> &Hypotheses<SharedSmoother<'static>> {
        &self.hypotheses
    }

    /// Takes in a motion; a choice of this number where it can be taken in several ways.
    ///
    /// # Errors
    /// If no hypothesis is left.
    pub fn move_by(
        &mut self,
        number: usize,
        measurement: &MotionMeasurement,
    ) -> Result<(), AssociationError> {
        let MotionMeasurement { from, to, modes, is_detachable } = measurement;
        let is_new = !self.poses.contains(to);
        let information = self.motion_information;
        let factor = |mode: Motion| PlanarBetween::new(Key::Robot(*from), Key::Robot(*to), mode, information);
        let addition = |estimator: &SharedSmoother<'static>, mode: Motion| {
            let addition = Addition::default().with(factor(mode));
            match pose(estimator, *from) {
                Some(pose) if is_new => addition.with_variable(Key::Robot(*to), pose.then(mode).to_value()),
                _ => addition,
            }
        };
        self.poses.insert(*to);
        if let ([mode], false) = (modes.as_slice(), is_detachable) {
            return self.hypotheses.observe(|hypothesis| addition(hypothesis.estimator(), *mode));
        }
        let false_share = if *is_detachable { self.noise.false_share } else { 0.0 };
        let log_share = libm::log((1.0 - false_share) / modes.len() as f64);
        let log_true = log_share + log_normalizer(&information);
        let log_false = libm::log(false_share) - libm::log(2.0 * PI) - self.log_area();
        self.hypotheses.choose(|hypothesis| {
            let estimator = hypothesis.estimator();
            let mut alternatives: Vec<Alternative<'static>> = (modes.iter().enumerate())
                .map(|(label, mode)| Alternative {
                    label,
                    addition: addition(estimator, *mode),
                    log_weight: log_true,
                    claims: None,
                })
                .collect();
            if *is_detachable {
                let addition = Addition::default();
                alternatives.push(Alternative {
                    label: modes.len(),
                    addition,
                    log_weight: log_false,
                    claims: None,
                });
            }
            Frame { choices: vec![Choice { number, alternatives }], log_weight: 0.0 }
        })
    }

    /// Takes in what was seen from a pose at one moment: a landmark is seen once. Measurements with several candidates are choices, numbered by
    /// `numbers`.
    ///
    /// # Errors
    /// If no hypothesis is left.
    pub fn see(
        &mut self,
        from: usize,
        numbers: &[usize],
        seen: &[PointMeasurement],
    ) -> Result<(), AssociationError> {
        let mut taken = BTreeSet::new();
        for PointMeasurement { candidates, measured } in seen {
            if let [landmark] = candidates.as_slice() {
                taken.insert(*landmark);
                let is_new = self.landmarks.insert(*landmark);
                self.hypotheses.observe(|hypothesis| {
                    sighting(
                        hypothesis.estimator(),
                        from,
                        *landmark,
                        *measured,
                        is_new,
                        &self.point_information,
                    )
                })?;
            }
        }
        let open: Vec<(usize, &PointMeasurement)> = numbers
            .iter()
            .copied()
            .zip(seen)
            .filter(|(_, measurement)| measurement.candidates.len() != 1)
            .collect();
        if open.is_empty() {
            return Ok(());
        }
        let information = self.point_information;
        let log_seen = log_normalizer(&information);
        let log_new = log_seen - self.log_area();
        self.hypotheses.choose(|hypothesis| {
            let choices = open.iter().map(|(number, measurement)| {
                let free = measurement
                    .candidates
                    .iter()
                    .enumerate()
                    .filter(|(_, landmark)| !taken.contains(*landmark));
                let alternatives = free.map(|(label, &landmark)| {
                    let is_new = hypothesis.estimator().value(Key::Landmark(landmark)).is_none();
                    let addition = sighting(
                        hypothesis.estimator(),
                        from,
                        landmark,
                        measurement.measured,
                        is_new,
                        &information,
                    );
                    let log_weight = if is_new { log_new } else { log_seen };
                    Alternative { label, addition, log_weight, claims: Some(landmark) }
                });
                Choice { number: *number, alternatives: alternatives.collect() }
            });
            Frame { choices: choices.collect(), log_weight: 0.0 }
        })
    }

    /// Brings all up to date.
    ///
    /// # Errors
    /// If no hypothesis is left.
    pub fn settle(&mut self) -> Result<(), AssociationError> {
        self.hypotheses.settle()
    }

    /// Brings all to the maxima.
    ///
    /// # Errors
    /// If no hypothesis is left.
    pub fn refine(&mut self) -> Result<(), AssociationError> {
        self.hypotheses.refine()
    }

    fn log_area(&self) -> f64 {
        libm::log(PI * self.noise.reach * self.noise.reach)
    }
}

fn sighting(
    estimator: &SharedSmoother<'static>,
    from: usize,
    landmark: usize,
    measured: Vector2<f64>,
    is_new: bool,
    information: &Matrix2<f64>,
) -> Addition<'static> {
    let (robot, key) = (Key::Robot(from), Key::Landmark(landmark));
    let addition = Addition::default().with(PlanarPoint::new(robot, key, measured, *information));
    match pose(estimator, from) {
        Some(pose) if is_new => {
            let point = pose.point(measured);
            addition.with_variable(key, Value::Vector(DVector::from_column_slice(point.as_slice())))
        }
        _ => addition,
    }
}

/// A pose under a hypothesis.
pub fn pose(estimator: &SharedSmoother<'_>, step: usize) -> Option<Motion> {
    match estimator.value(Key::Robot(step))? {
        Value::Vector(value) => Motion::from_value(&value),
        _ => None,
    }
}

/// A landmark under a hypothesis.
pub fn landmark(estimator: &SharedSmoother<'_>, landmark: usize) -> Option<Vector2<f64>> {
    match estimator.value(Key::Landmark(landmark))? {
        Value::Vector(value) if value.len() == 2 => Some(Vector2::new(value[0], value[1])),
        _ => None,
    }
}
