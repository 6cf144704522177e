//! `webdataset` and `parquet`: labelled crops in shards.

use super::images::licences;
use super::{Format, Index, Need, Source, taken_up};
use crate::command::error::BenchError;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::{Episode, InstanceId, Seed, Split};
use vantage_formats::{CropLayout, CropOptions, CropWriter};
use vantage_sim::rollout::Rollout;

/// Crops in a shard: about 40 MB of them.
const CROPS_PER_SHARD: u64 = 10_000;
/// What the licence of a dataset with meshes of others is called.
const OTHERS: &str = "other";
/// That of one whose every mesh is procedural.
const OURS: &str = "cc0-1.0";

/// A dataset of crops.
pub struct Crops {
    /// None where it was finished before.
    writer: Option<CropWriter>,
    split: Split,
    /// Crops still to come that are there already.
    skip: u64,
    /// Of the scene's meshes.
    licences: BTreeMap<InstanceId, String>,
    /// What each object of the episode under way is a copy of.
    originals: BTreeMap<InstanceId, InstanceId>,
}

impl Crops {
    /// Opens the folder.
    pub fn open(root: &Path, layout: CropLayout, source: &Source<'_>) -> Result<Self, BenchError> {
        let options = CropOptions {
            layout,
            name: source.name.to_owned(),
            licence: if source.scene.meshes().is_empty() { OURS } else { OTHERS }.to_owned(),
            samples_per_shard: CROPS_PER_SHARD,
        };
        let opened = CropWriter::open(root, options, source.provenance.clone())?;
        let (writer, skip) = taken_up(opened, source.progress);
        let licences = licences(source.scene);
        Ok(Self { writer, split: source.split, skip, licences, originals: BTreeMap::new() })
    }
}

impl Format for Crops {
    fn need(&mut self, seed: Seed, index: &Index) -> Result<Need, BenchError> {
        if self.writer.is_none() {
            return Ok(Need::Nothing);
        }
        match index.get(seed) {
            Some(counts) if counts.crops <= self.skip => {
                self.skip -= counts.crops;
                Ok(Need::Nothing)
            }
            _ => Ok(Need::Episode),
        }
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        self.originals = rollout.world.objects.iter().map(|object| (object.id, object.original)).collect();
        Ok(())
    }

    fn episode(&mut self, episode: &Episode) -> Result<(), BenchError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        for sample in episode.samples(self.split) {
            if self.skip > 0 {
                self.skip -= 1;
            } else {
                let original = self.originals.get(&sample.instance);
                if let Some(licence) = original.and_then(|original| self.licences.get(original)) {
                    writer.add_licence(sample.instance, licence);
                }
                writer.push(sample)?;
            }
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), BenchError> {
        if let Some(writer) = self.writer {
            writer.finish()?;
        }
        Ok(())
    }
}
