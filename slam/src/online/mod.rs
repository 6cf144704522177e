//! The posterior after every step, as a robot has it: what is observed enters once, and is kept as a factor.

mod crops;
mod growing_posterior;
mod map;
mod orienting;
mod relocation;
mod sighted;
mod step;

pub use crops::Reading;
pub use step::StepObservations;

use crate::incremental::{Smoother, Update};
use crate::input::{EstimateError, check_observations};
use crate::orientation::Budget;
use crate::problem::Problem;
use crate::settings::{GeometrySettings, OdometrySettings};
use crate::variable::Key;
use map::Map;
use nalgebra::Matrix6;
use vantage_dataset::{Camera, Observations, Pose};

/// What a step may spend on looking for orientations, in crops that are encoded: 0.1 ms each for the shipped models.
const CROPS_A_STEP: f64 = 300.0;

/// The posterior of the steps so far.
pub struct Online<'m> {
    odometry: OdometrySettings,
    geometry: Option<GeometrySettings>,
    observations: Observations,
    map: Map<'m>,
}

impl<'m> Online<'m> {
    /// Before the first step of a robot with a camera; without `geometry` by odometry alone, without `reading` without crops.
    pub(crate) fn new(
        odometry: OdometrySettings,
        geometry: Option<GeometrySettings>,
        reading: Option<Reading<'m>>,
        (camera, robot_from_camera): (Camera, Pose),
    ) -> Self {
        let observations = Observations {
            timestamps: Vec::new(),
            camera,
            robot_from_camera,
            odometry: Vec::new(),
            detections: Vec::new(),
            landmarks: Vec::new(),
        };
        Self { odometry, geometry, observations, map: Map::new(reading) }
    }

    /// Steps taken in.
    pub fn steps(&self) -> usize {
        self.observations.steps()
    }

    /// Takes in the next step, and brings the posterior up to date; nothing changes where what is observed is refused.
    pub fn advance(&mut self, new: StepObservations) -> Result<Update, EstimateError> {
        let step = self.steps();
        let StepObservations { timestamp, odometry, mut detections, landmarks } = new;
        detections.sort_by_key(|detection| detection.track);
        let mut timestamps = self.observations.timestamps.clone();
        timestamps.push(timestamp);
        let alone = Observations { timestamps, odometry, detections, landmarks, ..self.observations };
        check_observations(&alone, &self.odometry)?;
        let Observations { odometry, detections, landmarks, .. } = alone;
        if step > 0 && !odometry.iter().any(|o| o.from.max(o.to) == step) {
            return Err(EstimateError::Unreached { step });
        }

        self.observations.timestamps.push(timestamp);
        self.map.move_robot(step, &odometry, &self.odometry);
        self.observations.odometry.extend(odometry);
        let first = self.observations.detections.len();
        self.observations.detections.extend(detections);
        if let Some(geometry) = &self.geometry {
            let problem = Problem { observations: &self.observations, settings: geometry };
            for index in first..self.observations.detections.len() {
                self.map.see(&problem, index)?;
            }
            for sighting in landmarks {
                self.map.see_landmark(&problem, sighting);
            }
            self.map.orient(&problem, Budget::new(CROPS_A_STEP))?;
        }
        let mut update = self.map.update().map_err(|_| EstimateError::Indefinite { step })?;
        if let Some(geometry) = &self.geometry {
            let problem = Problem { observations: &self.observations, settings: geometry };
            let settled = self.map.relocate(&problem).map_err(|_| EstimateError::Indefinite { step })?;
            update.is_unfinished = settled.map_or(update.is_unfinished, |settled| !settled);
        }
        Ok(update)
    }

    /// Goes to the maximum, as of a whole episode: from that by geometry alone, what has no place may get one, all orientations are looked for
    /// again, and second modes of ambiguous ones are tried. It is reached where no step promises to lower the cost by more than `promise` nats, which is
    /// `sqrt(2 promise)` deviations; false where one does after so many `iterations` from any start.
    pub fn settle(&mut self, promise: f64, iterations: usize) -> Result<bool, EstimateError> {
        let last = self.steps().saturating_sub(1);
        let of = |settings| Problem { observations: &self.observations, settings };
        let problem = self.geometry.as_ref().map(of);
        self.map.settle(problem.as_ref(), (promise, iterations), |_| EstimateError::Indefinite { step: last })
    }

    /// The robot's pose at a step in the frame of its first.
    pub fn world_from_robot(&self, step: usize) -> Option<Pose> {
        self.map.posterior().values().pose(Key::Robot(step)).copied()
    }

    /// Covariance of the right perturbation of the robot's pose at a step, rotation first.
    pub fn pose_covariance(&self, step: usize) -> Option<Matrix6<f64>> {
        let covariance = self.map.posterior().covariance(Key::Robot(step))?;
        Some(Matrix6::from_column_slice(covariance.as_slice()))
    }

    /// The maximum and the marginals of all variables.
    pub fn smoother(&self) -> &Smoother<'m> {
        self.map.posterior()
    }
}
