//! `webdataset` and `parquet`: labelled crops in shards.

use super::{Format, Index, Need, Source, taken_up};
use crate::exit::BenchError;
use std::path::Path;
use vantage_dataset::layout::{CropLayout, CropOptions, CropWriter};
use vantage_dataset::{Episode, Seed, Split};

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
        let (mut writer, skip) = taken_up(opened, source.progress);
        for (instance, licence) in super::images::licences(source.scene) {
            writer.iter_mut().for_each(|writer| writer.add_licence(instance, &licence));
        }
        Ok(Self { writer, split: source.split, skip })
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

    fn episode(&mut self, episode: &Episode) -> Result<(), BenchError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        for sample in episode.samples(self.split) {
            if self.skip > 0 {
                self.skip -= 1;
            } else {
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
