//! `tum` and `g2o`: the true trajectory, and what odometry alone makes of it.

use super::claim::claimed;
use super::{Format, Index, Need, Source};
use crate::command::error::BenchError;
use crate::result::output_folder::OutputFolder;
use crate::result::trajectory::Trajectory;
use std::path::Path;
use vantage_dataset::{Seed, Split};
use vantage_formats::{Inventory, g2o};
use vantage_sim::rollout::Rollout;
use vantage_slam::initial::dead_reckoning;

const TUM: &str = "tum";
const G2O: &str = "g2o";

/// Text files of poses.
pub struct Trajectories<'a> {
    out: &'a OutputFolder,
    as_graph: bool,
    split: Split,
    inventory: Inventory,
}

impl<'a> Trajectories<'a> {
    /// `tum/<seed>/truth.tum` and `odometry.tum`.
    pub fn tum(out: &'a OutputFolder, source: &Source<'_>) -> Result<Self, BenchError> {
        Self::open(out, source, false)
    }

    /// `g2o/<seed>.g2o`.
    pub fn g2o(out: &'a OutputFolder, source: &Source<'_>) -> Result<Self, BenchError> {
        Self::open(out, source, true)
    }

    fn open(out: &'a OutputFolder, source: &Source<'_>, as_graph: bool) -> Result<Self, BenchError> {
        let layout = if as_graph { G2O } else { TUM };
        let folder = out.path().join(layout);
        // What renders, and which code, does not reach these files.
        let reaching = |what: &str| ["scene_hash", "split"].contains(&what);
        let inventory = claimed(&folder, layout, &source.provenance, reaching)?;
        Ok(Self { out, as_graph, split: source.split, inventory })
    }
}

impl Format for Trajectories<'_> {
    fn need(&mut self, _: Seed, _: &Index) -> Result<Need, BenchError> {
        Ok(Need::Rollout)
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        self.inventory.withdraw()?;
        let seed = rollout.seed.0;
        let by_odometry = dead_reckoning(rollout.steps(), &rollout.odometry);
        if self.as_graph {
            let name = format!("{seed}.g2o");
            let graph = g2o::encode(&by_odometry, &rollout.odometry);
            self.out.write(Path::new(G2O).join(&name), graph.as_bytes())?;
            self.inventory.add(name, self.split, rollout.steps() as u64);
            return Ok(());
        }
        let truth = rollout.drive.world_from_robot.clone();
        for (name, poses) in [("truth", truth), ("odometry", by_odometry)] {
            let trajectory = Trajectory::new(rollout.drive.timestamps.clone(), poses)?;
            self.out.write_trajectory(format!("{TUM}/{seed}/{name}.tum"), &trajectory)?;
        }
        self.inventory.add(seed.to_string(), self.split, rollout.steps() as u64);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), BenchError> {
        Ok(self.inventory.finish(&[])?)
    }
}
