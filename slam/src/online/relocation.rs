//! A robot that was set down somewhere: where on the floor, and at which heading, the objects that it knows may have it.
//!
//! Bearings to few objects have many maxima in the heading, and that nearest to a guess is mostly wrong. So headings all round are tried. At each
//! the robot stands where it sees known objects as far off as their size tells, in the mean over its sightings since.

use super::sighted::Sighted;
use crate::incremental::{Indefinite, Smoother};
use crate::initial::dead_reckoning;
use crate::mapping::place_object;
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use vantage_dataset::Pose;

/// Headings that are tried.
const HEADINGS: usize = 24;
/// When the descent from one of them ends: the nats that a step promises, and iterations.
const PROMISE: f64 = 1e-3;
const ITERATIONS: usize = 30;
/// Objects known from before, seen since, after which no other heading is tried: bearings to three fix a pose.
const ENOUGH: usize = 3;

/// A robot that was set down at a step and sees few objects that it knows.
pub(super) struct Lost<'a> {
    /// Poses since it was set down, as if that had not moved it.
    poses: Vec<Pose>,
    since: usize,
    /// Sightings since of objects that were seen before, with their tracks and sizes, metres.
    known: Vec<(usize, &'a Sighting, f64)>,
    /// What has a place only since.
    new: Vec<Key>,
}

impl<'a> Lost<'a> {
    /// `None` of a robot that was never set down, that sees nothing known at its last step, or that saw enough before it.
    pub fn new(problem: &Problem<'_>, sighted: &'a Sighted, values: &Values) -> Option<Self> {
        let observations = problem.observations;
        let last = observations.steps().checked_sub(1)?;
        let (unknown, known): (Vec<_>, Vec<_>) = observations.odometry.iter().partition(|o| o.is_unknown());
        let since = unknown.iter().map(|o| o.from.max(o.to)).max()?;
        if known.iter().any(|o| o.from.max(o.to) == since) {
            return None;
        }
        let seen_again = |seen: &[Sighting], until: usize| {
            seen.first().is_some_and(|first| first.step < since)
                && seen.iter().any(|sighting| (since..until).contains(&sighting.step))
        };
        let is_seen_now = |seen: &[Sighting]| seen.last().is_some_and(|newest| newest.step == last);
        let again = |until: usize| sighted.objects.values().filter(move |seen| seen_again(seen, until));
        if again(last).count() >= ENOUGH || !again(last + 1).any(|seen| is_seen_now(seen)) {
            return None;
        }
        let before = values.pose(Key::Robot(since.checked_sub(1)?))?;
        let sizes: BTreeMap<usize, f64> = sighted
            .objects
            .iter()
            .filter_map(|(&track, seen)| {
                let before: Vec<Sighting> = seen.iter().copied().filter(|seen| seen.step < since).collect();
                place_object(problem, values, track, &before).ok()?;
                Some((track, problem.object_size(values, track, &before)?))
            })
            .collect();
        let known = sizes.iter().flat_map(|(&track, &size)| {
            let since = sighted.objects[&track].iter().filter(move |sighting| sighting.step >= since);
            since.map(move |sighting| (track, sighting, size))
        });
        let known = known.collect();
        let reckoned = dead_reckoning(observations.steps(), &observations.odometry);
        let poses = (since..=last).map(|step| before * reckoned[since].inv_mul(&reckoned[step])).collect();
        let objects = sighted.objects.keys().filter(|track| !sizes.contains_key(track));
        let landmarks =
            sighted.landmarks.iter().filter(|(_, seen)| seen.iter().all(|seen| seen.step >= since));
        let new = objects.map(|&track| Key::Object(track));
        let new = new.chain(landmarks.map(|(&landmark, _)| Key::Landmark(landmark))).collect();
        Some(Self { poses, since, known, new })
    }

    /// Goes to the most probable of the places and headings, where that is more probable than where the posterior has the robot. True if all is settled
    /// then; `None` where there is no such place.
    pub fn relocate(
        &self,
        problem: &Problem<'_>,
        smoother: &mut Smoother<'_>,
    ) -> Result<Option<bool>, Indefinite> {
        let candidates = (0..HEADINGS).filter_map(|k| {
            let values = self.set_down(problem, smoother.values(), TAU * k as f64 / HEADINGS as f64)?;
            let cost = smoother.cost_with(&values)?;
            Some((cost, values))
        });
        let Some((_, values)) = candidates.min_by(|(a, _), (b, _)| a.total_cmp(b)) else { return Ok(None) };
        let values = values.iter().map(|(key, value)| (key, value.clone()));
        Ok(Some(smoother.try_settle(values, PROMISE, ITERATIONS)?))
    }

    /// Poses since, and what was first seen since, with the robot turned by `yaw`.
    fn set_down(&self, problem: &Problem<'_>, values: &Values, yaw: f64) -> Option<Values> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        let turn = Pose::from_parts(Translation3::identity(), turn);
        let mut places = Vec::new();
        for &(track, sighting, size) in &self.known {
            let Some(object) = values.get(Key::Object(track)).and_then(Value::position) else { continue };
            let camera =
                turn * self.poses[sighting.step - self.since] * problem.observations.robot_from_camera;
            let range = size / (sighting.angular_size * problem.settings.size_over_box_side);
            places.push(object - (camera * Point3::from(sighting.ray_in_camera * range)).coords);
        }
        if places.is_empty() {
            return None;
        }
        let mut place = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
        place.z = 0.0;
        let floor = Pose::from_parts(Translation3::from(place), UnitQuaternion::identity()) * turn;
        let first = Key::Robot(self.since);
        let moved = floor * self.poses[0] * values.pose(first)?.inverse();
        let mut set_down = Values::default();
        for (k, pose) in self.poses.iter().enumerate() {
            set_down.insert(Key::Robot(self.since + k), Value::Pose(floor * pose));
        }
        for &key in &self.new {
            let there = match values.get(key) {
                Some(Value::Pose(pose)) => Value::Pose(moved * pose),
                Some(Value::Point(point)) => Value::Point((moved * Point3::from(*point)).coords),
                _ => continue,
            };
            set_down.insert(key, there);
        }
        Some(set_down)
    }
}
