//! What was made of the observations so far: the growing posterior, and objects and landmarks on their way into it.

use super::orienting::{Oriented, Orienting};
use crate::estimate::Dropped;
use crate::extents::{add_ellipsoid, edges};
use crate::graph::Graph;
use crate::incremental::{Smoother, Thresholds};
use crate::input::EstimateError;
use crate::mapping::{place_landmark, place_object};
use crate::orientation::Budget;
use crate::problem::{Problem, add_bias, add_gauge, add_motion};
use crate::semantics::{SemanticObject, Semantics};
use crate::settings::{OdometrySettings, OrientationSettings, SemanticSettings};
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use std::collections::{BTreeMap, VecDeque};
use vantage_dataset::{LandmarkSighting, Odometry, Pose};
use vantage_model::{AnswerError, ObservationModel};

/// Found on episodes of bearings: these leave poses up to 0.07 of their deviations from where they belong, and one and a half times the first
/// up to 0.13.
const THRESHOLDS: Thresholds = Thresholds { relinearization: 0.002, propagation: 2e-5, rounds: 3 };

/// How crops are read.
#[derive(Clone, Copy)]
pub struct Reading<'m> {
    /// By what.
    pub model: &'m dyn ObservationModel,
    /// How far it is trusted.
    pub semantics: SemanticSettings,
    /// How first orientations are looked for.
    pub orientation: OrientationSettings,
}

/// An object, by what was seen of it so far.
#[derive(Default)]
struct Track {
    sightings: Vec<Sighting>,
    is_placed: bool,
    semantic: Option<SemanticObject>,
    /// Sightings when its orientation was last looked for.
    searched_at: usize,
    /// Whether its orientation is to be looked for.
    is_due: bool,
}

/// A landmark, by what was seen of it so far.
#[derive(Default)]
struct Landmark {
    sightings: Vec<LandmarkSighting>,
    is_placed: bool,
}

/// What was made of the observations.
pub(super) struct Map<'m> {
    reading: Option<Reading<'m>>,
    pub smoother: Smoother<'m>,
    tracks: BTreeMap<usize, Track>,
    landmarks: BTreeMap<usize, Landmark>,
    /// Objects whose orientation is to be looked for, in the order that they asked.
    due: VecDeque<usize>,
    orienting: Option<Orienting<'m>>,
    pub dropped: Dropped,
}

impl<'m> Map<'m> {
    /// Empty, of a robot that reads crops as `reading` says.
    pub fn new(reading: Option<Reading<'m>>) -> Self {
        Self {
            reading,
            smoother: Smoother::new(THRESHOLDS),
            tracks: BTreeMap::new(),
            landmarks: BTreeMap::new(),
            due: VecDeque::new(),
            orienting: None,
            dropped: Dropped::default(),
        }
    }

    /// A new pose, by the first motion that reaches it from an earlier one; the first is the origin.
    pub fn move_robot(&mut self, step: usize, odometry: &[Odometry], settings: &OdometrySettings) {
        let mut graph = Graph::default();
        let mut first = Values::default();
        if step == 0 {
            add_gauge(&mut graph);
            add_bias(&mut graph, &mut first, settings);
        }
        let at = |step: usize| self.smoother.values().pose(Key::Robot(step));
        let reached = odometry.iter().find_map(|o| match (at(o.from), at(o.to)) {
            (Some(from), _) => Some(from * o.robot_from_robot),
            (_, Some(to)) => Some(to * o.robot_from_robot.inverse()),
            _ => None,
        });
        let mut pose = reached.unwrap_or_else(Pose::identity);
        pose.rotation.renormalize();
        for o in odometry {
            add_motion(&mut graph, o, settings);
        }
        self.smoother.add_variable(Key::Robot(step), Value::Pose(pose));
        self.smoother.add(graph, &first);
    }

    /// Takes in a detection.
    pub fn see(&mut self, problem: &Problem<'_>, index: usize) -> Result<(), EstimateError> {
        let detection = &problem.observations.detections[index];
        let Some(sighting) = Sighting::new(&problem.observations.camera, index, detection) else {
            self.dropped.truncated += 1;
            return Ok(());
        };
        let number = detection.track;
        let mut track = self.tracks.remove(&number).unwrap_or_default();
        track.sightings.push(sighting);
        if track.is_placed {
            self.see_again(problem, number, &mut track, sighting)?;
        } else {
            let values = self.smoother.values();
            if let Ok(point) = place_object(problem, values, number, &track.sightings) {
                let mut first = values.clone();
                first.insert(Key::Object(number), Value::Point(point));
                self.place(problem, number, &mut track, first, None);
            }
        }
        if self.reading.is_some()
            && track.is_placed
            && !track.is_due
            && track.sightings.len() >= 2 * track.searched_at
        {
            track.is_due = true;
            self.due.push_back(number);
        }
        self.tracks.insert(number, track);
        Ok(())
    }

    /// Goes on to look for orientations, of one object at a time among all that was seen of it, those first that have waited longest; false
    /// where nothing is to be done.
    pub fn orient(&mut self, problem: &Problem<'_>, mut budget: Budget) -> Result<bool, EstimateError> {
        let Some(reading) = self.reading else { return Ok(false) };
        let mut orienting = match self.orienting.take() {
            Some(orienting) => orienting,
            None => {
                let Some(number) = self.due.pop_front() else { return Ok(false) };
                let Some(track) = self.tracks.get_mut(&number) else { return Ok(true) };
                track.searched_at = track.sightings.len();
                match Orienting::new(problem, number, &track.sightings, self.smoother.values()) {
                    Some(orienting) => orienting,
                    None => {
                        track.is_due = false;
                        self.dropped.undefined_viewpoint += track.sightings.len();
                        return Ok(true);
                    }
                }
            }
        };
        if !orienting.advance(problem, reading, &mut self.dropped, &mut budget)? {
            self.orienting = Some(orienting);
            return Ok(true);
        }
        let (number, searched) = (orienting.track, orienting.sightings());
        let Some(mut track) = self.tracks.remove(&number) else { return Ok(true) };
        let mut values = self.smoother.values().clone();
        let mut found = orienting.found(&values);
        if let Some(found) = &mut found {
            let semantics = Semantics {
                problem: *problem,
                model: reading.model,
                settings: reading.semantics,
                domain: None,
            };
            for sighting in &track.sightings[searched..] {
                let view = semantics.view(&values, &found.object, sighting, &mut self.dropped)?;
                found.object.views.extend(view);
            }
        }
        self.smoother.remove_object(number);
        for key in [Key::Latent(number), Key::Extents(number), Key::Offset(number)] {
            values.remove(key);
        }
        self.place(problem, number, &mut track, values, found);
        track.is_due = false;
        self.tracks.insert(number, track);
        Ok(true)
    }

    /// Adds an object that `values` have a place for, with all that was seen of it; its crops where an orientation was found.
    fn place(
        &mut self,
        problem: &Problem<'_>,
        number: usize,
        track: &mut Track,
        mut values: Values,
        found: Option<Oriented>,
    ) {
        let key = Key::Object(number);
        if let Some(position) = values.get(key).and_then(Value::position) {
            values.insert(key, Value::Point(position));
        }
        let mut graph = Graph::default();
        problem.add_offset(&mut values, number);
        match &problem.settings.extents {
            Some(extents) => {
                add_ellipsoid(problem, extents, &mut graph, &mut values, number, &track.sightings);
            }
            None => problem.add_bearings(&mut graph, number, &track.sightings),
        }
        track.is_placed = true;
        track.semantic = None;
        if let (Some(Oriented { object, best }), Some(reading)) = (found, self.reading) {
            let Reading { model, semantics: settings, .. } = reading;
            let semantics = Semantics { problem: *problem, model, settings, domain: None };
            semantics.add_factors(&mut graph, &object, &object.views, best.world_from_object.rotation);
            values.insert(key, Value::Pose(best.world_from_object));
            values.insert(Key::Latent(number), Value::Vector(best.latent));
            track.semantic = Some(object);
        }
        self.dropped.non_finite += self.smoother.add(graph, &values);
    }

    /// Adds one more sighting of a placed object.
    fn see_again(
        &mut self,
        problem: &Problem<'_>,
        number: usize,
        track: &mut Track,
        sighting: Sighting,
    ) -> Result<(), AnswerError> {
        let mut graph = Graph::default();
        let values = self.smoother.values();
        if values.get(Key::Extents(number)).is_some() {
            graph.push(edges(problem, number, &sighting));
            problem.add_depth(&mut graph, number, &sighting);
        } else {
            problem.add_views(&mut graph, number, &[sighting]);
        }
        if let (Some(object), Some(reading)) = (&mut track.semantic, self.reading) {
            let Reading { model, semantics: settings, .. } = reading;
            let semantics = Semantics { problem: *problem, model, settings, domain: None };
            if let Some(view) = semantics.view(values, object, &sighting, &mut self.dropped)? {
                graph.push(semantics.factor(object, &view));
                object.views.push(view);
            }
        }
        self.dropped.non_finite += self.smoother.add(graph, &Values::default());
        Ok(())
    }

    /// Takes in a sighting of a landmark.
    pub fn see_landmark(&mut self, problem: &Problem<'_>, sighting: LandmarkSighting) {
        let values = self.smoother.values();
        let landmark = self.landmarks.entry(sighting.landmark).or_default();
        let mut graph = Graph::default();
        let mut first = Values::default();
        landmark.sightings.push(sighting);
        if landmark.is_placed {
            problem.add_projections(&mut graph, &[sighting]);
        } else {
            let mut sightings = landmark.sightings.clone();
            let Ok(point) = place_landmark(problem, values, sighting.landmark, &mut sightings) else {
                return;
            };
            first.insert(Key::Landmark(sighting.landmark), Value::Point(point));
            problem.add_projections(&mut graph, &sightings);
            landmark.is_placed = true;
        }
        self.dropped.landmark_behind_camera += self.smoother.add(graph, &first);
    }
}
