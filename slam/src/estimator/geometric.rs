//! P(X, L, O | U, Z^g): odometry, bearings to object centres, and pixels of landmarks.

use super::Estimator;
use crate::estimate::{Dropped, Estimate, Unresolved, UnresolvedReason};
use crate::extents::add_ellipsoid;
use crate::graph::Graph;
use crate::initial::start_poses;
use crate::input::{EstimateError, check_observations, check_settings};
use crate::mapping::{place_landmarks, place_objects};
use crate::online::{Online, Reading, StepObservations};
use crate::posterior::{Posterior, Seen};
use crate::problem::{Problem, add_odometry};
use crate::set_down::set_down;
use crate::settings::{GeometrySettings, OdometrySettings, Settings, SolverSettings};
use crate::sighting::{landmark_sightings, sightings};
use crate::solve::Outcome;
use crate::variable::{Key, Value, Values};
use vantage_dataset::{Camera, Observations, Pose};

/// Steps of the longest episode that is driven through for another start: a step takes milliseconds, and more where an object is seen
/// on end.
const LONGEST_DRIVEN: usize = 1000;

/// The motion model of Eq. 3 and the geometric measurements of Eq. 6.
#[derive(Clone, Copy, Debug)]
pub struct Geometric {
    pub(super) solver: SolverSettings,
    odometry: OdometrySettings,
    geometry: GeometrySettings,
}

impl Geometric {
    /// An estimator with some settings.
    pub fn new(settings: &Settings) -> Self {
        let Settings { solver, odometry, geometry, .. } = *settings;
        Self { solver, odometry, geometry }
    }

    /// The estimator after every step, with the crops as `reading` has them.
    pub(super) fn online_by<'m>(
        &self,
        reading: Option<Reading<'m>>,
        mounted: (Camera, Pose),
    ) -> Result<Online<'m>, EstimateError> {
        check_settings(&self.odometry)?;
        check_settings(&self.geometry)?;
        Ok(Online::new(self.odometry, Some(self.geometry), reading, mounted))
    }

    /// The problem of an episode.
    pub(super) fn problem<'a>(&'a self, observations: &'a Observations) -> Problem<'a> {
        Problem { observations, settings: &self.geometry }
    }

    /// The posterior of an episode, with room for the factors of a model that lives for `'m`.
    pub(super) fn posterior<'m>(&self, observations: &Observations) -> Result<Posterior<'m>, EstimateError> {
        check_settings(&self.solver)?;
        check_settings(&self.odometry)?;
        check_settings(&self.geometry)?;
        check_observations(observations, &self.odometry)?;
        let mut reckoned = start_poses(observations);
        set_down(&self.problem(observations), &mut reckoned, &sightings(observations).0);
        let posterior = self.maximum(observations, reckoned);
        if posterior.is_plausible() || observations.steps() > LONGEST_DRIVEN {
            return Ok(posterior);
        }
        Ok(match self.driven(observations) {
            Some(driven) => posterior.or(self.maximum(observations, driven), &self.solver),
            None => posterior,
        })
    }

    /// The robot's poses as they are after the last step, each step added to the maximum of those before it: dead reckoning's drift is gone. `None`
    /// where a step is refused.
    fn driven(&self, observations: &Observations) -> Option<Values> {
        let mut online = self.online_by(None, (observations.camera, observations.robot_from_camera)).ok()?;
        for step in StepObservations::of(observations) {
            online.advance(step).ok()?;
        }
        let mut poses = Values::default();
        for step in 0..observations.steps() {
            poses.insert(Key::Robot(step), Value::Pose(online.world_from_robot(step)?));
        }
        Some(poses)
    }

    /// The maximum that these poses, and what is placed from them, lead to.
    fn maximum<'m>(&self, observations: &Observations, mut start: Values) -> Posterior<'m> {
        let problem = self.problem(observations);
        let (mut whole, truncated) = sightings(observations);
        let mut dropped = Dropped { truncated: truncated.values().sum(), ..Dropped::default() };
        let mut unresolved = place_objects(&problem, &mut start, &whole);
        for lost in &unresolved {
            dropped.unresolved += whole.remove(&lost.track).map_or(0, |of_track| of_track.len());
        }
        for &track in truncated.keys() {
            if !whole.contains_key(&track) && !unresolved.iter().any(|lost| lost.track == track) {
                unresolved.push(Unresolved { track, reason: UnresolvedReason::Truncated });
            }
        }
        unresolved.sort_by_key(|lost| lost.track);
        let mut landmarks = landmark_sightings(observations);
        let unresolved_landmarks = place_landmarks(&problem, &mut start, &mut landmarks, &mut dropped);

        let mut graph = Graph::default();
        add_odometry(&mut graph, &mut start, observations, &self.odometry);
        for (&track, of_track) in &whole {
            match &self.geometry.extents {
                Some(extents) => {
                    add_ellipsoid(&problem, extents, &mut graph, &mut start, track, of_track);
                }
                None => problem.add_bearings(&mut graph, track, of_track),
            }
        }
        for of_landmark in landmarks.values() {
            problem.add_projections(&mut graph, of_landmark);
        }
        let landmarks = landmarks.into_iter().map(|(landmark, seen)| (landmark, seen.len())).collect();
        let posterior = Posterior::maximum(graph, start, whole, &self.solver);
        Posterior { unresolved, landmarks, unresolved_landmarks, dropped, ..posterior }
    }

    /// The estimate of a posterior; `semantic` tells of the objects with orientation and latent.
    pub(super) fn estimate_of(
        &self,
        posterior: Posterior<'_>,
        observations: &Observations,
        semantic: impl Fn(usize) -> Option<Seen>,
    ) -> Estimate {
        let problem = self.problem(observations);
        let nothing_seen = posterior.sightings.is_empty() && posterior.landmarks.is_empty();
        let mut estimate = posterior.estimate(observations, &self.solver, |values, track, of_track| {
            semantic(track).unwrap_or_else(|| Seen {
                size: problem.object_size(values, track, of_track),
                margin: None,
                semantic_views: 0,
            })
        });
        if nothing_seen && estimate.outcome == Outcome::Converged {
            estimate.outcome = Outcome::NothingObserved;
        }
        estimate
    }
}

impl Estimator for Geometric {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Ok(self.estimate_of(self.posterior(observations)?, observations, |_| None))
    }

    fn online(&self, camera: Camera, robot_from_camera: Pose) -> Option<Result<Online<'_>, EstimateError>> {
        Some(self.online_by(None, (camera, robot_from_camera)))
    }
}
