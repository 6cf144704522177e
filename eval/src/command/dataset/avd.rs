//! `avd`: a grid of images in the layout of the Active Vision dataset, one scan a seed.

use super::claim::{add_licences, claimed, of_each_seed};
use super::error::DatasetError;
use super::images::licences;
use super::{Format, Index, Need, Source};
use crate::command::error::BenchError;
use crate::result::output_folder::OutputError;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::{Capture, Episode, InstanceId, Seed, Split};
use vantage_formats::Inventory;
use vantage_formats::avd::{AvdWriter, GRID, HEADINGS, ID_MAPS, ScanName, SceneType};
use vantage_sim::rollout::Rollout;
use vantage_sim::scene::PathSpec;

/// Homes are numbered from 1, with three digits.
const HOMES: u64 = 999;
/// How far a grid may be from that of the dataset, metres.
const TOLERANCE: f64 = 1e-9;

/// Folders of scans.
///
/// A file `.<scan>.unfinished` beside a scan's folder says that the folder is ours and not whole yet.
pub struct Avd {
    root: PathBuf,
    split: Split,
    licences: BTreeMap<InstanceId, String>,
    scan: Option<(AvdWriter, PathBuf)>,
    inventory: Inventory,
}

impl Avd {
    /// Refuses a scene that the layout has no place for.
    pub fn check(source: &Source<'_>) -> Result<(), BenchError> {
        let unsuitable = |reason: String| Err(DatasetError::Unsuitable { format: "avd", reason }.into());
        let PathSpec::Grid { spacing, headings, .. } = &source.scene.robot().path else {
            return unsuitable("robot.path is not grid".to_owned());
        };
        if *headings != HEADINGS || (spacing - GRID).abs() > TOLERANCE {
            return unsuitable(format!(
                "its grid has {HEADINGS} headings and points {GRID} m apart, robot.path.grid {headings} and {spacing}"
            ));
        }
        if source.scene.world().look_alike.is_some_and(|tint| tint <= 0.0) {
            return unsuitable("a scan has no two equal objects, and world.look_alike is 0".to_owned());
        }
        source.require_seeds_below(HOMES, "avd")
    }

    /// Below `root`, of a scene that was checked.
    pub fn open(root: &Path, source: &Source<'_>) -> Result<Self, BenchError> {
        let inventory = claimed(root, "avd", &source.provenance, of_each_seed)?;
        let (root, licences) = (root.to_owned(), licences(source.scene));
        Ok(Self { root, split: source.split, licences, scan: None, inventory })
    }

    fn folder(&self, name: &ScanName) -> PathBuf {
        self.root.join(name.to_string())
    }

    fn mark(&self, name: &ScanName) -> PathBuf {
        self.root.join(format!(".{name}.unfinished"))
    }
}

fn name(seed: Seed) -> ScanName {
    ScanName { scene_type: SceneType::Home, scene: seed.0 as u16 + 1, scan: 1 }
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    move |source| OutputError { path, source }
}

impl Format for Avd {
    fn need(&mut self, _: Seed, _: &Index) -> Result<Need, BenchError> {
        Ok(Need::Captures)
    }

    fn wants(&mut self, rollout: &Rollout) -> bool {
        add_licences(&mut self.inventory, &self.licences, rollout);
        let name = name(rollout.seed);
        let finished = self.folder(&name).exists() && !self.mark(&name).exists();
        if finished {
            self.inventory.keep(name.to_string(), self.split, rollout.steps() as u64);
        }
        !finished
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        self.inventory.withdraw()?;
        let name = name(rollout.seed);
        let (folder, mark) = (self.folder(&name), self.mark(&name));
        if folder.exists() {
            fs::remove_dir_all(&folder).map_err(cannot(&folder))?;
        }
        fs::write(&mark, []).map_err(cannot(&mark))?;
        let writer = AvdWriter::create(&self.root, name, rollout.camera, &rollout.world.truth())?;
        self.scan = Some((writer, mark));
        Ok(())
    }

    fn image(&mut self, step: usize, capture: &Capture) -> Result<(), BenchError> {
        let Some((scan, _)) = &mut self.scan else { return Ok(()) };
        let step = step as u32;
        Ok(scan.push(step / HEADINGS, step % HEADINGS, capture)?)
    }

    fn episode(&mut self, episode: &Episode) -> Result<(), BenchError> {
        let Some((scan, mark)) = self.scan.take() else { return Ok(()) };
        scan.finish()?;
        fs::remove_file(&mark).map_err(cannot(&mark))?;
        let steps = episode.observations.steps() as u64;
        self.inventory.add(name(episode.seed).to_string(), self.split, steps);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), BenchError> {
        Ok(self.inventory.finish(&ID_MAPS)?)
    }
}
