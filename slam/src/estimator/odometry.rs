//! P(X | U): dead reckoning.

use super::Estimator;
use crate::estimate::Estimate;
use crate::graph::Graph;
use crate::initial::start_poses;
use crate::input::{EstimateError, check_observations, check_settings};
use crate::online::Online;
use crate::posterior::{Posterior, Seen};
use crate::problem::add_odometry;
use crate::settings::{OdometrySettings, Settings, SolverSettings};
use std::collections::BTreeMap;
use vantage_dataset::{Camera, Observations, Pose};

/// The motion model of Eq. 3 alone.
#[derive(Clone, Copy, Debug)]
pub struct OdometryOnly {
    solver: SolverSettings,
    odometry: OdometrySettings,
}

impl OdometryOnly {
    /// An estimator with some settings.
    pub fn new(settings: &Settings) -> Self {
        Self { solver: settings.solver, odometry: settings.odometry }
    }
}

impl Estimator for OdometryOnly {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        check_settings(&self.solver)?;
        check_settings(&self.odometry)?;
        check_observations(observations, &self.odometry)?;
        let (mut graph, mut start) = (Graph::default(), start_poses(observations));
        add_odometry(&mut graph, &mut start, observations, &self.odometry);
        let posterior = Posterior::maximum(graph, start, BTreeMap::new(), &self.solver);
        let nothing = Seen { size: None, margin: None, semantic_views: 0 };
        Ok(posterior.estimate(observations, &self.solver, |_, _, _| nothing))
    }

    fn online(&self, camera: Camera, robot_from_camera: Pose) -> Option<Result<Online<'_>, EstimateError>> {
        let mounted = (camera, robot_from_camera);
        Some(check_settings(&self.odometry).map(|()| Online::new(self.odometry, None, None, mounted)))
    }
}
