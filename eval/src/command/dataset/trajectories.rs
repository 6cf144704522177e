//! `tum` and `g2o`: the true trajectory, and what odometry alone makes of it.

use super::{Format, Index, Need};
use crate::exit::BenchError;
use crate::output::OutputFolder;
use crate::trajectory::Trajectory;
use vantage_dataset::Seed;
use vantage_dataset::store::write_g2o;
use vantage_sim::rollout::Rollout;
use vantage_slam::initial::dead_reckoning;

/// Text files of poses.
pub struct Trajectories<'a> {
    out: &'a OutputFolder,
    as_graph: bool,
}

impl<'a> Trajectories<'a> {
    /// `tum/<seed>/truth.tum` and `odometry.tum`.
    pub fn tum(out: &'a OutputFolder) -> Self {
        Self { out, as_graph: false }
    }

    /// `g2o/<seed>.g2o`.
    pub fn g2o(out: &'a OutputFolder) -> Self {
        Self { out, as_graph: true }
    }
}

impl Format for Trajectories<'_> {
    fn need(&mut self, _: Seed, _: &Index) -> Result<Need, BenchError> {
        Ok(Need::Rollout)
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        let seed = rollout.seed.0;
        let by_odometry = dead_reckoning(rollout.steps(), &rollout.odometry);
        if self.as_graph {
            self.out.write_with(format!("g2o/{seed}.g2o"), |path| {
                write_g2o(path, &by_odometry, &rollout.odometry).map(drop)
            })?;
            return Ok(());
        }
        let truth = rollout.drive.world_from_robot.clone();
        for (name, poses) in [("truth", truth), ("odometry", by_odometry)] {
            let trajectory = Trajectory::new(rollout.drive.timestamps.clone(), poses)?;
            self.out.write_trajectory(format!("tum/{seed}/{name}.tum"), &trajectory)?;
        }
        Ok(())
    }
}
