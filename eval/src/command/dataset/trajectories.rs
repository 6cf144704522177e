//! `tum` and `g2o`: the true trajectory, and what odometry alone makes of it.

use super::claim::{CLAIM, claim};
use super::{Format, Index, Need, Source};
use crate::error::BenchError;
use crate::output::OutputFolder;
use crate::trajectory::Trajectory;
use std::path::Path;
use vantage_dataset::layout::Inventory;
use vantage_dataset::store::{Provenance, write_g2o};
use vantage_dataset::{Seed, Split};
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
    pub fn tum(
        out: &'a OutputFolder,
        source: &Source<'_>,
        provenance: &Provenance,
    ) -> Result<Self, BenchError> {
        Self::open(out, source, provenance, false)
    }

    /// `g2o/<seed>.g2o`.
    pub fn g2o(
        out: &'a OutputFolder,
        source: &Source<'_>,
        provenance: &Provenance,
    ) -> Result<Self, BenchError> {
        Self::open(out, source, provenance, true)
    }

    fn open(
        out: &'a OutputFolder,
        source: &Source<'_>,
        provenance: &Provenance,
        as_graph: bool,
    ) -> Result<Self, BenchError> {
        let layout = if as_graph { G2O } else { TUM };
        let root = out.path().join(layout);
        claim(&root, provenance)?;
        let inventory = Inventory::begin(&root, layout, source.provenance.clone())?;
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
            self.out.write_with(Path::new(G2O).join(&name), |path| {
                write_g2o(path, &by_odometry, &rollout.odometry).map(drop)
            })?;
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
        Ok(self.inventory.finish(&[CLAIM])?)
    }
}
