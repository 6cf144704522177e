//! One episode, step by step, under all hypotheses.

use super::Place;
use super::hypothesizing::AssociationSettings;
use super::likeness::{Heading, Likeness};
use super::ratios::{Part, Ratios};
use super::relocation::{self, Piece};
use super::sensing::Sensing;
use super::tracklet::{Labels, NOTHING, Tracklet, Tracklets};
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
use vantage_dataset::{self as dataset, Odometry, Pose};

pub(super) type Estimated = Hypothesis<SharedSmoother<'static>>;

/// A tracklet's number, its first sighting, and what that shows.
type Begun<'s, R> = (usize, &'s Sighting, Option<R>);

/// What is believed so far.
pub(super) struct Scan<'a, L: Likeness> {
    odometry: &'a OdometrySettings,
    pub(super) ratios: Ratios<'a, L>,
    /// Steps without a sighting after which a tracklet has come to its end.
    pub(super) gap: usize,
    pub(super) sensing: Sensing<'a>,
    pub(super) tracklets: Tracklets<L>,
    /// Where the robot was carried last.
    piece: Option<Piece>,
    /// Where the robot was believed to be, step by step.
    places: Vec<Place>,
    pub(super) hypotheses: Hypotheses<SharedSmoother<'static>>,
}

impl<'a, L: Likeness> Scan<'a, L> {
    pub fn new(
        settings: &'a AssociationSettings,
        (odometry, geometry): (&'a OdometrySettings, &'a GeometrySettings),
        likeness: &'a L,
        seen: &'a dataset::Tracklets,
    ) -> Self {
        let hypotheses = Hypotheses::new(SharedSmoother::new(settings.thresholds), settings.limits);
        let sensing = Sensing { settings, geometry, observations: seen.observations() };
        Self {
            odometry,
            ratios: Ratios::new(likeness),
            gap: seen.gap(),
            sensing,
            tracklets: BTreeMap::new(),
            piece: None,
            places: Vec::new(),
            hypotheses,
        }
    }

    pub fn hypotheses(&self) -> &Hypotheses<SharedSmoother<'static>> {
        &self.hypotheses
    }

    /// Where the robot was believed to be, step by step.
    pub fn places(self) -> Vec<Place> {
        self.places
    }

    pub(super) fn problem(&self) -> Problem<'a> {
        Problem { observations: self.sensing.observations, settings: self.sensing.geometry }
    }

    /// Takes in a step: a motion, and sightings by their tracklets.
    pub fn advance(
        &mut self,
        step: usize,
        odometry: &[Odometry],
        seen: &BTreeMap<usize, Sighting>,
    ) -> Result<(), EstimateError> {
        let unsolved = |error: AssociationError| EstimateError::Association { step, error };
        if step > 0 && odometry.is_empty() {
            return Err(EstimateError::Unreached { step });
        }
        if odometry.iter().any(Odometry::is_unknown) {
            self.piece = Some(Piece { since: step });
        }
        self.move_robot(step, odometry).map_err(unsolved)?;
        self.follow(seen).map_err(unsolved)?;
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
        self.end(step)?;
        self.places.extend(self.place(step));
        Ok(())
    }

    /// Where the robot is likeliest to be: of the place with most weight about it, where its likeliest hypothesis has it. That the place is not known
    /// counts as one place.
    fn place(&self, step: usize) -> Option<Place> {
        let believed = |hypothesis: &Estimated| {
            let is_known = !self.is_lost(&Labels::of(hypothesis));
            let world_from_robot = pose(hypothesis, step)?;
            Some((hypothesis.weight(), Place { world_from_robot, is_known }))
        };
        let mut all: Vec<(f64, Place)> = self.hypotheses.all().iter().filter_map(believed).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let about = |place: &Place| -> f64 {
            all.iter().filter(|(_, other)| place.is_about(other)).map(|(weight, _)| weight).sum()
        };
        let masses: Vec<f64> = all.iter().map(|(_, place)| about(place)).collect();
        let best = (0..all.len()).rev().max_by(|a, b| masses[*a].total_cmp(&masses[*b]))?;
        Some(all[best].1)
    }

    /// All is brought up to date.
    pub fn finish(&mut self) -> Result<(), EstimateError> {
        let step = self.sensing.observations.steps().saturating_sub(1);
        let all: Vec<usize> = self.tracklets.keys().copied().collect();
        all.into_iter().try_for_each(|number| self.read_rest(number, step))?;
        self.hypotheses.refine().map_err(|error| EstimateError::Association { step, error })
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
            Addition { factors: factors.clone(), fresh, ..Addition::default() }
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
            let labels = Labels::of(hypothesis);
            let of = going
                .iter()
                .filter_map(|&(number, sighting)| Some(sensing.bearing(labels.object(number)?, sighting)));
            of.fold(Addition::default(), Addition::with)
        })?;
        self.hypotheses.choose(|hypothesis| {
            let labels = Labels::of(hypothesis);
            let of = |&(number, sighting): &(usize, &Sighting)| match labels.object(number) {
                None => libm::log(sensing.settings.clutter),
                Some(_) => sensing.log_normalizer(sighting),
            };
            Frame { choices: Vec::new(), log_weight: going.iter().map(of).sum() }
        })
    }

    /// Tracklets that begin: of an object that is known and not in view otherwise, of a new one, or of nothing.
    ///
    /// Those of one step are chosen together, but where a hypothesis does not know where the robot is: there the first says where that may be.
    fn meet(&mut self, step: usize, seen: &BTreeMap<usize, Sighting>) -> Result<(), EstimateError> {
        let mut begun = Vec::new();
        for (&number, sighting) in seen.iter().filter(|(number, _)| !self.tracklets.contains_key(number)) {
            begun.push((number, sighting, self.first_reading(sighting)?));
        }
        while !begun.is_empty() {
            let is_by_turns = self.sensing.settings.gate.is_some() || self.is_anyone_lost();
            let together = if is_by_turns { 1 } else { begun.len() };
            self.choose(step, begun.drain(..together).collect())?;
        }
        Ok(())
    }

    fn is_anyone_lost(&self) -> bool {
        self.hypotheses.all().iter().any(|hypothesis| self.is_lost(&Labels::of(hypothesis)))
    }

    /// Whether a hypothesis knows of a piece of the trajectory alone.
    fn is_lost(&self, labels: &Labels<'_>) -> bool {
        self.piece.is_some_and(|piece| piece.is_lost::<L>(labels, &self.tracklets))
    }

    /// Chooses what tracklets are that begin at a step.
    fn choose(&mut self, step: usize, begun: Vec<Begun<'_, L::Reading>>) -> Result<(), EstimateError> {
        let unsolved = |error: AssociationError| EstimateError::Association { step, error };
        self.hypotheses.settle().map_err(unsolved)?;
        let mut variance = self.heading_variance(step);
        let since = self.piece.map_or(0, |piece| piece.since);
        if self.piece.is_some() {
            variance = variance.min(relocation::VARIANCE);
        }
        let is_live =
            |tracklet: &Tracklet<L::Reading>| tracklet.began >= since && tracklet.last() + self.gap >= step;
        let live: Vec<usize> = self
            .tracklets
            .iter()
            .filter(|(_, tracklet)| is_live(tracklet))
            .map(|(number, _)| *number)
            .collect();
        let (sensing, tracklets, ratios, piece) = (self.sensing, &self.tracklets, &self.ratios, self.piece);
        let chosen = self.hypotheses.choose(|hypothesis| {
            let labels = Labels::of(hypothesis);
            let taken: Vec<usize> = live.iter().filter_map(|number| labels.object(*number)).collect();
            let objects: Vec<usize> = labels.objects().filter(|number| !taken.contains(number)).collect();
            let lost = piece.filter(|piece| piece.is_lost::<L>(&labels, tracklets));
            let is_placed = |object: &usize| lost.is_none_or(|piece| piece.has(*object, tracklets));
            let (placed, elsewhere): (Vec<usize>, Vec<usize>) = objects.into_iter().partition(is_placed);
            let yaw = pose(hypothesis, step).map_or(0.0, |pose| heading(&pose));
            let choices = begun.iter().map(|(number, sighting, reading)| {
                if let Some(gate) = sensing.settings.gate {
                    let alternatives = sensing.nearest(hypothesis, &placed, gate, (*number, sighting));
                    return Choice { number: *number, alternatives: alternatives.into_iter().collect() };
                }
                let log_normal = sensing.log_normalizer(sighting);
                let mut near: Vec<(f64, usize)> = (placed.iter())
                    .filter_map(|&object| Some((sensing.off(hypothesis, object, sighting)?, object)))
                    .collect();
                near.sort_by(|a, b| a.0.total_cmp(&b.0));
                let near = near.into_iter().take(sensing.settings.candidates);
                let of_known = near.map(|(_, object)| {
                    let mut parts = labels.parts(tracklets, object, None);
                    let before = ratios.log_ratio(&parts);
                    parts.extend(
                        reading
                            .as_ref()
                            .map(|reading| Part::new(*number, (1, reading), Heading { yaw, variance })),
                    );
                    Alternative {
                        label: object,
                        addition: Addition::default().with(sensing.bearing(object, sighting)),
                        log_weight: log_normal + ratios.log_ratio(&parts) - before,
                        claims: Some(object),
                    }
                });
                let mut alternatives: Vec<Alternative<'static>> = of_known.collect();
                for (piece, &object) in
                    lost.iter().flat_map(|piece| elsewhere.iter().map(move |object| (*piece, object)))
                {
                    let first = reading.as_ref().map(|reading| (reading, variance));
                    let seen = (*number, *sighting, first);
                    alternatives.extend(sensing.set_down(ratios, (&labels, tracklets), piece, object, seen));
                }
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
        chosen.map_err(unsolved)?;
        for (number, _, reading) in begun {
            let readings = reading.map(|reading| (1, reading)).into_iter().collect();
            let tracklet =
                Tracklet { began: step, sightings: Vec::new(), heading_variance: variance, readings };
            self.tracklets.insert(number, tracklet);
        }
        Ok(())
    }
}

pub(super) fn pose(hypothesis: &Estimated, step: usize) -> Option<Pose> {
    match hypothesis.estimator().value(Key::Robot(step))? {
        Value::Pose(pose) => Some(pose),
        _ => None,
    }
}

/// A pose upright: of its rotation the heading alone.
pub(super) fn level(pose: &Pose) -> Pose {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading(pose));
    Pose::from_parts(pose.translation, rotation)
}

/// Of a pose about the world's z axis.
pub(super) fn heading(pose: &Pose) -> f64 {
    let forward = pose.rotation * Vector3::x();
    libm::atan2(forward.y, forward.x)
}
