//! The true and the estimated pose of each step, which trajectory scores compare.

use crate::exit::{Ends, Exit};
use crate::result::trajectory::Trajectory;
use thiserror::Error;
use vantage_dataset::Pose;
use vantage_dataset::se3::is_finite;

/// How far apart two timestamps may be to count as one step, seconds: evo's default.
pub const MAX_TIME_DIFFERENCE: f64 = 0.01;

/// Finite poses, one true and one estimated a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairs {
    truth: Vec<Pose>,
    estimate: Vec<Pose>,
    times: Vec<f64>,
}

/// Why truth and estimate cannot be compared.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PairsError {
    /// Not one estimate a step.
    #[error("{estimate} estimated poses for {truth} true ones: each step needs both")]
    Length {
        /// True poses.
        truth: usize,
        /// Estimated poses.
        estimate: usize,
    },
    /// A pose is NaN or infinite.
    #[error("the {of} pose of step {step} is not finite")]
    NotFinite {
        /// `true` or `estimated`.
        of: &'static str,
        /// The step.
        step: usize,
    },
}

impl Ends for PairsError {
    fn exit(&self) -> Exit {
        Exit::Bug
    }
}

impl Pairs {
    /// The poses of equal steps.
    pub fn by_step(
        truth_world_from_robot: &[Pose],
        estimate_world_from_robot: &[Pose],
    ) -> Result<Self, PairsError> {
        let (truth, estimate) = (truth_world_from_robot, estimate_world_from_robot);
        if truth.len() != estimate.len() {
            return Err(PairsError::Length { truth: truth.len(), estimate: estimate.len() });
        }
        for (of, poses) in [("true", truth), ("estimated", estimate)] {
            if let Some(step) = poses.iter().position(|p| !is_finite(p)) {
                return Err(PairsError::NotFinite { of, step });
            }
        }
        Ok(Self { truth: truth.to_vec(), estimate: estimate.to_vec(), times: Vec::new() })
    }

    /// The poses nearest in time, for each pose of the shorter trajectory (the estimate where both are as long), within so many seconds, as evo
    /// associates: a pose of the longer one may serve twice.
    pub fn by_time(truth: &Trajectory, estimate: &Trajectory, max_difference: f64) -> Self {
        let mut pairs = Self { truth: Vec::new(), estimate: Vec::new(), times: Vec::new() };
        let estimate_longer = estimate.len() > truth.len();
        let (short, long) = if estimate_longer { (truth, estimate) } else { (estimate, truth) };
        for (i, &time) in short.timestamps().iter().enumerate() {
            let Some(j) = nearest(long.timestamps(), time, max_difference) else { continue };
            let (t, e) = if estimate_longer { (i, j) } else { (j, i) };
            pairs.truth.push(truth.world_from_robot()[t]);
            pairs.estimate.push(estimate.world_from_robot()[e]);
            pairs.times.push(estimate.timestamps()[e]);
        }
        pairs
    }

    /// `world_from_robot`, true.
    pub fn truth(&self) -> &[Pose] {
        &self.truth
    }

    /// `world_from_robot`, estimated, in the estimate's own world frame.
    pub fn estimate(&self) -> &[Pose] {
        &self.estimate
    }

    /// The estimate's timestamps, seconds, where poses met in time; empty where they are of equal steps.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Each step's `first_from_robot`, true and estimated: what is left of the poses once both first poses are
    /// laid on each other. Equal poses stay equal to the bit.
    pub fn from_first(&self) -> impl ExactSizeIterator<Item = (Pose, Pose)> {
        let first_from_world = |poses: &[Pose]| poses.first().map_or_else(Pose::identity, Pose::inverse);
        let (truth, estimate) = (first_from_world(&self.truth), first_from_world(&self.estimate));
        self.truth.iter().zip(&self.estimate).map(move |(t, e)| (truth * t, estimate * e))
    }

    /// The true world's frame in the estimate's: the transform that lays the first estimated pose on the first
    /// true one. The identity where there is no pose.
    pub fn true_world_from_estimate_world(&self) -> Pose {
        match (self.truth.first(), self.estimate.first()) {
            (Some(truth), Some(estimate)) => truth * estimate.inverse(),
            _ => Pose::identity(),
        }
    }
}

/// The index of the timestamp nearest to `t`, within `max_difference`.
pub fn nearest(timestamps: &[f64], t: f64, max_difference: f64) -> Option<usize> {
    let after = timestamps.partition_point(|&x| x <= t);
    let candidates = [after.checked_sub(1), (after < timestamps.len()).then_some(after)];
    candidates
        .into_iter()
        .flatten()
        .map(|i| (i, (timestamps[i] - t).abs()))
        .filter(|(_, difference)| *difference <= max_difference)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn unequal_lengths_and_non_finite_poses_are_refused() {
        let one = [Pose::identity()];
        assert_eq!(Pairs::by_step(&one, &[]), Err(PairsError::Length { truth: 1, estimate: 0 }));
        let nan = [Pose::translation(0.0, f64::NAN, 0.0)];
        assert_eq!(Pairs::by_step(&one, &nan), Err(PairsError::NotFinite { of: "estimated", step: 0 }));
    }

    #[test]
    fn aligning_lays_the_first_poses_on_each_other() {
        let truth = [Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, 0.2, 0.3))];
        let estimate = [Pose::new(Vector3::new(-1.0, 0.0, 3.0), Vector3::new(0.0, -0.2, 2.3))];
        let pairs = Pairs::by_step(&truth, &estimate).unwrap();
        let aligned = pairs.true_world_from_estimate_world() * estimate[0];
        assert!((aligned.to_homogeneous() - truth[0].to_homogeneous()).norm() < 1e-12);
    }
}
