//! A posterior that grows with the steps: poses, objects and landmarks, by odometry, boxes and pixels, and by what else is known of objects.

use super::sighted::Sighted;
use crate::extents::{add_ellipsoid, edges};
use crate::factor::Factor;
use crate::graph::Graph;
use crate::incremental::{Smoother, Thresholds};
use crate::mapping::{place_landmark, place_object, robots};
use crate::problem::{Problem, add_bias, add_gauge, add_motion};
use crate::settings::OdometrySettings;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use std::collections::BTreeSet;
use vantage_dataset::{LandmarkSighting, Odometry, Pose};

/// These leave poses within 0.1 of their deviations from where they belong, on simulated episodes of bearings.
const THRESHOLDS: Thresholds =
    Thresholds { relinearization: 0.002, propagation: 2e-5, iterations: 2, rejections: 8 };

/// The posterior, and what of it has a place.
pub(super) struct GrowingPosterior<'m> {
    pub smoother: Smoother<'m>,
    objects: BTreeSet<usize>,
    landmarks: BTreeSet<usize>,
}

impl<'m> GrowingPosterior<'m> {
    /// Empty.
    pub fn new() -> Self {
        let (objects, landmarks) = Default::default();
        Self { smoother: Smoother::new(THRESHOLDS), objects, landmarks }
    }

    /// Variables as they are.
    pub fn values(&self) -> &Values {
        self.smoother.values()
    }

    /// Whether an object has a place.
    pub fn has(&self, track: usize) -> bool {
        self.objects.contains(&track)
    }

    /// A new pose, by the first motion that reaches it from an earlier one; the first is the origin.
    pub fn move_robot(&mut self, step: usize, odometry: &[Odometry], settings: &OdometrySettings) {
        let mut graph = Graph::default();
        let mut first = Values::default();
        if step == 0 {
            add_gauge(&mut graph);
            add_bias(&mut graph, &mut first, settings);
        }
        let at = |step: usize| self.values().pose(Key::Robot(step));
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

    /// Takes in the last of an object's sightings; all of them, as soon as these place it.
    pub fn see(&mut self, problem: &Problem<'_>, track: usize, sightings: &[Sighting]) {
        let mut graph = Graph::default();
        if !self.has(track) {
            if let Ok(point) = place_object(problem, self.values(), track, sightings) {
                self.place(problem, track, sightings, Value::Point(point), (graph, Values::default()));
            }
            return;
        }
        let Some(sighting) = sightings.last() else { return };
        let edges = edges(problem, track, sighting);
        if edges.residual(self.values()).is_some() {
            graph.push(edges);
            problem.add_depth(&mut graph, track, sighting);
        } else {
            problem.add_views(&mut graph, track, &[*sighting]);
        }
        self.smoother.add(graph, &Values::default());
    }

    /// Adds an object at a first place, by all of its boxes and by more factors with their first values; in place of what was known of it.
    pub fn place(
        &mut self,
        problem: &Problem<'_>,
        track: usize,
        sightings: &[Sighting],
        place: Value,
        (more, mut first): (Graph<'m>, Values),
    ) {
        self.smoother.remove_object(track);
        self.objects.insert(track);
        let mut values = robots(self.values(), sightings.iter().map(|sighting| sighting.step));
        if let Some(center) = place.position() {
            values.insert(Key::Object(track), Value::Point(center));
        }
        problem.add_offset(&mut values, track);
        let mut graph = Graph::default();
        match &problem.settings.extents {
            Some(extents) => add_ellipsoid(problem, extents, &mut graph, &mut values, track, sightings),
            None => problem.add_bearings(&mut graph, track, sightings),
        }
        values.insert(Key::Object(track), place);
        for (key, value) in values.iter() {
            first.insert(key, value.clone());
        }
        graph.extend(more);
        self.smoother.add(graph, &first);
    }

    /// Looks again for places of what has none, among all that was seen of it; true if any is found.
    pub fn place_more(&mut self, problem: &Problem<'_>, sighted: &Sighted) -> bool {
        let before = self.objects.len() + self.landmarks.len();
        for (&track, sightings) in &sighted.objects {
            if !self.has(track) {
                self.see(problem, track, sightings);
            }
        }
        for (landmark, sightings) in &sighted.landmarks {
            if !self.landmarks.contains(landmark) {
                self.see_landmark(problem, sightings);
            }
        }
        self.objects.len() + self.landmarks.len() > before
    }

    /// Takes in the last of a landmark's sightings; all of them, as soon as these place it.
    pub fn see_landmark(&mut self, problem: &Problem<'_>, sightings: &[LandmarkSighting]) {
        let Some(&sighting) = sightings.last() else { return };
        let landmark = sighting.landmark;
        let mut graph = Graph::default();
        let mut first = Values::default();
        if self.landmarks.contains(&landmark) {
            problem.add_projections(&mut graph, &[sighting]);
        } else {
            let mut in_front = sightings.to_vec();
            let Ok(point) = place_landmark(problem, self.values(), landmark, &mut in_front) else { return };
            first.insert(Key::Landmark(landmark), Value::Point(point));
            problem.add_projections(&mut graph, &in_front);
            self.landmarks.insert(landmark);
        }
        self.smoother.add(graph, &first);
    }
}
