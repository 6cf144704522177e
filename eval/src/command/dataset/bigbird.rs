//! `bigbird`: a turntable's images as those of the BigBIRD rig, one folder an object.

use super::claim::{add_licences, claimed, of_each_seed};
use super::error::DatasetError;
use super::images::licences;
use super::{Format, Index, Need, Source};
use crate::command::error::BenchError;
use crate::command::folder::FolderError;
use crate::result::output_folder::OutputError;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::{Capture, Episode, InstanceId, Pose, Seed, Split};
use vantage_formats::bigbird::{BigBirdWriter, CAMERAS};
use vantage_formats::{Inventory, object_name};
use vantage_sim::rollout::Rollout;
use vantage_sim::scene::PathSpec;

/// Marks an object's folder as finished.
const LAST: &str = "calibration.h5";
const WORK: &str = ".partial";

/// Folders of objects.
pub struct BigBird {
    root: PathBuf,
    /// Degrees between two angles.
    degrees: u32,
    object: Option<(BigBirdWriter, String)>,
    split: Split,
    licences: BTreeMap<InstanceId, String>,
    inventory: Inventory,
}

impl BigBird {
    /// Degrees from one angle of the turntable to the next; refuses a scene that the layout has no place for.
    pub fn degrees(source: &Source<'_>) -> Result<u32, BenchError> {
        let unsuitable =
            |reason: String| BenchError::from(DatasetError::Unsuitable { format: "bigbird", reason });
        let PathSpec::Turntable { elevations_deg, angles, .. } = &source.scene.robot().path else {
            return Err(unsuitable("robot.path is not turntable".to_owned()));
        };
        if elevations_deg.len() != CAMERAS {
            let got = elevations_deg.len();
            return Err(unsuitable(format!(
                "the rig has {CAMERAS} cameras, robot.path.turntable {got} elevations"
            )));
        }
        if 360 % angles != 0 {
            return Err(unsuitable(format!(
                "angles are whole degrees, and robot.path.turntable.angles, {angles}, does not divide 360"
            )));
        }
        Ok(360 / angles)
    }

    /// Below `root`.
    pub fn open(root: &Path, source: &Source<'_>) -> Result<Self, BenchError> {
        let degrees = Self::degrees(source)?;
        let inventory = claimed(root, "bigbird", &source.provenance, of_each_seed)?;
        let (root, split, licences) = (root.to_owned(), source.split, licences(source.scene));
        Ok(Self { root, degrees, object: None, split, licences, inventory })
    }

    fn cannot(&self) -> impl Fn(std::io::Error) -> OutputError + use<> {
        let path = self.root.clone();
        move |source| OutputError { path: path.clone(), source }
    }
}

impl Format for BigBird {
    fn need(&mut self, _: Seed, _: &Index) -> Result<Need, BenchError> {
        Ok(Need::Captures)
    }

    fn wants(&mut self, rollout: &Rollout) -> bool {
        add_licences(&mut self.inventory, &self.licences, rollout);
        let objects = rollout.world.truth();
        let Some(name) = objects.first().map(object_name) else { return false };
        let finished = self.root.join(&name).join(LAST).exists();
        if finished {
            self.inventory.keep(name, self.split, rollout.steps() as u64);
        }
        !finished
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        self.inventory.withdraw()?;
        let work = self.root.join(WORK);
        if work.exists() {
            fs::remove_dir_all(&work).map_err(self.cannot())?;
        }
        fs::create_dir_all(&work).map_err(self.cannot())?;
        let objects = rollout.world.truth();
        let Some(object) = objects.first() else { return Ok(()) };
        let folder = self.root.join(object_name(object));
        if folder.exists() {
            return Err(FolderError::NotOurs { folder }.into());
        }
        let height = rollout.world.furnishing.stands.first().map_or(0.0, |stand| stand.height);
        let world_from_table = Pose::translation(0.0, 0.0, height);
        let writer = BigBirdWriter::create(&work, object, 0, world_from_table)?;
        self.object = Some((writer, object_name(object)));
        Ok(())
    }

    fn image(&mut self, step: usize, capture: &Capture) -> Result<(), BenchError> {
        let Some((writer, _)) = &mut self.object else { return Ok(()) };
        let (angle, camera) = ((step / CAMERAS) as u32 * self.degrees, step % CAMERAS + 1);
        Ok(writer.push(camera, angle, capture)?)
    }

    fn episode(&mut self, episode: &Episode) -> Result<(), BenchError> {
        let Some((writer, name)) = self.object.take() else { return Ok(()) };
        writer.finish()?;
        let (work, folder) = (self.root.join(WORK), self.root.join(&name));
        fs::rename(work.join(&name), &folder)
            .and_then(|()| fs::remove_dir_all(&work))
            .map_err(self.cannot())?;
        self.inventory.add(name, self.split, episode.observations.steps() as u64);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), BenchError> {
        Ok(self.inventory.finish(&[])?)
    }
}
