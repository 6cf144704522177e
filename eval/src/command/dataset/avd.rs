//! `avd`: a grid of images in the layout of the Active Vision dataset, one scan a seed.

use super::{Format, Index, Need};
use crate::exit::BenchError;
use crate::output::OutputError;
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::layout::avd::{AvdWriter, HEADINGS, ScanName, SceneType};
use vantage_dataset::{Capture, Episode, Seed};
use vantage_sim::rollout::Rollout;
use vantage_sim::scene::{CheckedScene, PathSpec};

/// Marks a scan as finished: it is written last.
const LAST: &str = "annotations.json";
/// Homes are numbered with three digits.
const HOMES: u64 = 999;

/// Folders of scans.
pub struct Avd {
    root: PathBuf,
    scan: Option<AvdWriter>,
}

impl Avd {
    /// Below `root`.
    pub fn open(root: &Path, scene: &CheckedScene) -> Result<Self, BenchError> {
        match &scene.robot().path {
            PathSpec::Grid { headings, .. } if *headings == HEADINGS => {
                Ok(Self { root: root.to_owned(), scan: None })
            }
            _ => Err(BenchError::Unsuitable {
                format: "avd",
                reason: format!("robot.path is no grid of {HEADINGS} headings"),
            }),
        }
    }
}

fn name(seed: Seed) -> Result<ScanName, BenchError> {
    let home = seed.0 + 1;
    let scene = u16::try_from(home).ok().filter(|_| home <= HOMES).ok_or_else(|| BenchError::Unsuitable {
        format: "avd",
        reason: format!("homes have three digits, and seed {} would be home {home}", seed.0),
    })?;
    Ok(ScanName { scene_type: SceneType::Home, scene, scan: 1 })
}

impl Format for Avd {
    fn need(&mut self, seed: Seed, _: &Index) -> Result<Need, BenchError> {
        let folder = self.root.join(name(seed)?.to_string());
        Ok(if folder.join(LAST).exists() { Need::Nothing } else { Need::Captures })
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        let scan = name(rollout.seed)?;
        let folder = self.root.join(scan.to_string());
        for part in ["jpg_rgb", "high_res_depth"] {
            let path = folder.join(part);
            if path.exists() {
                fs::remove_dir_all(&path).map_err(|source| OutputError { path, source })?;
            }
        }
        let writer = AvdWriter::create(&self.root, scan, rollout.camera, &rollout.world.truth())?;
        self.scan = Some(writer);
        Ok(())
    }

    fn image(&mut self, step: usize, capture: &Capture) -> Result<(), BenchError> {
        let Some(scan) = &mut self.scan else { return Ok(()) };
        let step = step as u32;
        Ok(scan.push(step / HEADINGS, step % HEADINGS, capture)?)
    }

    fn episode(&mut self, _: &Episode) -> Result<(), BenchError> {
        self.scan.take().map_or(Ok(()), |scan| Ok(scan.finish()?))
    }
}
