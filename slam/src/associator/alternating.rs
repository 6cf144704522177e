//! Association and estimation by turns: expectation maximisation, and max-mixtures with a null hypothesis.
//!
//! ```text
//! w(t, o)  is proportional to  n_o  prod_i N(bearing_i; X, o)  p(crops of t | crops of o)        or detections of nothing     i in t
//! X, O     =  argmin  cost of odometry + sum_t sum_o  w(t, o) cost of the bearings of t to o
//! ```
//!
//! `n_o` counts the tracklets of an object. Expectation maximisation takes `w` as it is (Bowman et al., ICRA 2017); a max-mixture gives each
//! tracklet's likeliest all of it (Olson and Agarwal, IJRR 2013). Both begin with what a gated nearest neighbour finds.

use super::hypothesizing::{AssociationSettings, Hypothesizing};
use super::likeness::{Blind, Heading, Likeness};
use super::ratios::{Part, Ratios};
use super::scan::heading;
use super::sensing::Sensing;
use super::view::own_frame;
use super::{Association, Associator};
use crate::factor::{BearingFactor, Factor};
use crate::graph::Graph;
use crate::initial::start_poses;
use crate::input::EstimateError;
use crate::mapping::place_object;
use crate::problem::{Problem, add_odometry};
use crate::settings::{GeometrySettings, OdometrySettings, Settings};
use crate::sighting::Sighting;
use crate::solve::{Limits, solve};
use crate::variable::{Key, Value, Values};
use std::collections::{BTreeMap, BTreeSet};
use vantage_dataset::Tracklets;

/// Turns at most.
const TURNS: usize = 10;
/// A start for the next turn needs no more.
const LIMITS: Limits = Limits { iterations: 30, tolerance: 1e-6 };
/// Weights below are none.
const LEAST_WEIGHT: f64 = 0.01;

/// Whose weights a tracklet's bearings have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// Expectation maximisation.
    Expected,
    /// A max-mixture.
    Largest,
}

/// Association and estimation by turns.
pub struct Alternating<L> {
    start: Hypothesizing<Blind>,
    settings: AssociationSettings,
    odometry: OdometrySettings,
    geometry: GeometrySettings,
    likeness: L,
    weights: Weights,
}

impl<L: Likeness> Alternating<L> {
    /// With an estimator's settings of odometry and boxes. `settings` have a gate, by which it begins.
    pub fn new(estimator: &Settings, settings: AssociationSettings, likeness: L, weights: Weights) -> Self {
        let Settings { odometry, geometry, .. } = *estimator;
        let start = Hypothesizing::new(estimator, settings, Blind);
        Self { start, settings, odometry, geometry, likeness, weights }
    }
}

/// An episode in the middle of it.
struct Turn<'a, L: Likeness> {
    owner: &'a Alternating<L>,
    seen: &'a Tracklets,
    tracklets: BTreeMap<usize, Vec<Sighting>>,
    readings: BTreeMap<usize, L::Reading>,
    values: Values,
    ratios: Ratios<'a, L>,
    /// Of each tracklet, objects with their weights.
    weights: BTreeMap<usize, Vec<(usize, f64)>>,
}

impl<L: Likeness> Associator for Alternating<L> {
    fn associate(&self, seen: &Tracklets) -> Result<Association, EstimateError> {
        let begun = self.start.associate(seen)?;
        let mut tracklets: BTreeMap<usize, Vec<Sighting>> = BTreeMap::new();
        for (index, detection) in seen.observations().detections.iter().enumerate() {
            if let Some(sighting) = Sighting::new(&seen.observations().camera, index, detection) {
                tracklets.entry(detection.track).or_default().push(sighting);
            }
        }
        let weights = tracklets
            .keys()
            .filter_map(|&number| Some((number, vec![((*begun.objects().get(number)?)?, 1.0)])))
            .collect();
        let values = start_poses(seen.observations());
        let mut turn = Turn {
            owner: self,
            seen,
            tracklets,
            readings: BTreeMap::new(),
            values,
            ratios: Ratios::new(&self.likeness),
            weights,
        };
        turn.place();
        for count in 0..TURNS {
            turn.estimate();
            if count == 0 {
                turn.read()?;
            }
            let before = turn.objects();
            turn.weigh();
            if turn.objects() == before {
                break;
            }
        }
        let objects = turn.objects();
        Ok(Association::certain((0..seen.count()).map(|number| objects.get(&number).copied()).collect()))
    }
}

impl<L: Likeness> Turn<'_, L> {
    fn problem(&self) -> Problem<'_> {
        Problem { observations: self.seen.observations(), settings: &self.owner.geometry }
    }

    fn sensing(&self) -> Sensing<'_> {
        let Alternating { settings, geometry, .. } = self.owner;
        Sensing { settings, geometry, observations: self.seen.observations() }
    }

    /// The likeliest object of each tracklet that is of one.
    fn objects(&self) -> BTreeMap<usize, usize> {
        let likeliest = |ways: &Vec<(usize, f64)>| {
            ways.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|(object, _)| *object)
        };
        self.weights.iter().filter_map(|(number, ways)| Some((*number, likeliest(ways)?))).collect()
    }

    /// Puts objects where their tracklets have them; one that no parallax places, at the depth that its first box tells.
    fn place(&mut self) {
        let mut of_object: BTreeMap<usize, Vec<Sighting>> = BTreeMap::new();
        for (number, object) in self.objects() {
            of_object.entry(object).or_default().extend(&self.tracklets[&number]);
        }
        for (object, sightings) in of_object {
            let placed = place_object(&self.problem(), &self.values, object, &sightings).ok();
            let by_size = || {
                let first = sightings.first()?;
                let camera = self.problem().world_from_camera(&self.values, first.step)?;
                Some((camera * self.sensing().first_place(first)).coords)
            };
            if let Some(place) = placed.or_else(by_size) {
                self.values.insert(Key::Object(object), Value::Point(place));
            }
        }
    }

    /// The estimate under the weights.
    fn estimate(&mut self) {
        let mut graph = Graph::default();
        let mut values = self.values.clone();
        add_odometry(&mut graph, &mut values, self.seen.observations(), &self.owner.odometry);
        let mut joined = BTreeSet::new();
        for (number, ways) in &self.weights {
            for &(object, weight) in ways {
                joined.insert(Key::Object(object));
                for sighting in &self.tracklets[number] {
                    graph.push(self.bearing(object, sighting, weight));
                }
            }
        }
        let is_held = |key: &Key| !matches!(key, Key::Object(_)) || joined.contains(key);
        let mut start = Values::default();
        values
            .iter()
            .filter(|(key, _)| is_held(key))
            .for_each(|(key, value)| start.insert(key, value.clone()));
        self.values = solve(&graph, start, |_| true, LIMITS).values;
    }

    fn bearing(&self, object: usize, sighting: &Sighting, weight: f64) -> BearingFactor {
        self.sensing().weighted_bearing(object, sighting, weight)
    }

    /// What crops of each tracklet show, from where the estimate has them.
    fn read(&mut self) -> Result<(), EstimateError> {
        let mut readings = BTreeMap::new();
        for (&number, object) in &self.objects() {
            let sightings = &self.tracklets[&number];
            let place = self.values.get(Key::Object(*object)).and_then(|value| value.position());
            let pose = |step| self.values.pose(Key::Robot(step)).copied();
            let values = place.and_then(|place| own_frame(sightings, place, pose));
            let Some(values) = values else { continue };
            readings.insert(number, self.owner.likeness.read(&self.problem(), &values, sightings)?);
        }
        self.readings = readings;
        Ok(())
    }

    /// Weighs the objects of each tracklet anew.
    fn weigh(&mut self) {
        let objects = self.objects();
        let mut counts: BTreeMap<usize, f64> = BTreeMap::new();
        objects.values().for_each(|object| *counts.entry(*object).or_default() += 1.0);
        let weights = self.tracklets.keys().map(|&number| {
            let log_weight = |(&object, count): (&usize, &f64)| {
                let bearings = self.log_bearings(object, number)?;
                Some((Some(object), libm::log(*count) + bearings + self.log_ratio(&objects, object, number)))
            };
            let mut logs: Vec<(Option<usize>, f64)> = counts.iter().filter_map(log_weight).collect();
            let sightings = self.tracklets[&number].len() as f64;
            logs.push((None, sightings * libm::log(self.owner.settings.clutter)));
            (number, self.shared_out(&logs))
        });
        self.weights = weights.collect();
    }

    /// Weights of objects, by their logarithms.
    fn shared_out(&self, logs: &[(Option<usize>, f64)]) -> Vec<(usize, f64)> {
        let largest = logs.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = logs.iter().map(|(_, log)| libm::exp(log - largest)).sum();
        let share = |log: f64| match self.owner.weights {
            Weights::Expected => libm::exp(log - largest) / total,
            Weights::Largest => f64::from(log == largest),
        };
        let of_object = |(object, log): &(Option<usize>, f64)| Some(((*object)?, share(*log)));
        logs.iter().filter_map(of_object).filter(|(_, weight)| *weight >= LEAST_WEIGHT).collect()
    }

    /// `log` of the density of a tracklet's bearings if it is of an object; none where that lies behind a camera.
    fn log_bearings(&self, object: usize, number: usize) -> Option<f64> {
        let log = |sighting: &Sighting| {
            let cost = self.bearing(object, sighting, 1.0).cost(&self.values)?;
            Some(self.sensing().log_normalizer(sighting) - cost)
        };
        self.tracklets[&number].iter().map(log).sum()
    }

    /// What crops tell of a tracklet and an object's others.
    fn log_ratio(&self, objects: &BTreeMap<usize, usize>, object: usize, number: usize) -> f64 {
        let part = |number: usize| {
            let first = self.tracklets[&number].first()?;
            let yaw = heading(self.values.pose(Key::Robot(first.step))?);
            let sightings = self.tracklets[&number].len();
            Some(Part::new(number, (sightings, self.readings.get(&number)?), Heading { yaw, variance: 0.0 }))
        };
        let others = objects.iter().filter(|(other, of)| **of == object && **other != number);
        let mut parts: Vec<Part<'_, L::Reading>> = others.filter_map(|(other, _)| part(*other)).collect();
        let before = self.ratios.log_ratio(&parts);
        parts.extend(part(number));
        self.ratios.log_ratio(&parts) - before
    }
}
