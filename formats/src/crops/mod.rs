//! Labelled crops in shards.

mod options;
#[cfg(feature = "parquet")]
mod parquet;
mod row;
mod webdataset;

use super::shard::{LayoutManifest, Opened, ShardedFolder, TarShard};
pub use options::{CropLayout, CropOptions};
#[cfg(feature = "parquet")]
use parquet::{ParquetShard, card};
use rayon::prelude::*;
use row::Row;
use serde_json::json;
use std::io;
use std::path::Path;
use vantage_dataset::store::{Fault, Provenance, StoreError, pose_fields};
use vantage_dataset::{Camera, InstanceId, Sample, Split};

/// How many crops are encoded at once, and how many rows a row group of Parquet has.
const BATCH: usize = 1000;

/// Writes crops, in the order in which they come.
///
/// A shard holds crops of one split: those of one split should come together.
#[derive(Debug)]
pub struct CropWriter {
    folder: ShardedFolder,
    options: CropOptions,
    shard: Option<Shard>,
    /// Checked, to be encoded, all for the shard.
    batch: Vec<Sample>,
}

/// A shard under way.
#[derive(Debug)]
struct Shard {
    split: Split,
    samples: u64,
    files: Files,
}

#[derive(Debug)]
enum Files {
    WebDataset(TarShard),
    #[cfg(feature = "parquet")]
    Parquet(ParquetShard),
}

impl CropWriter {
    /// Opens a folder, which is made if need be. One that holds anything else is refused, as is a dataset that was
    /// begun with other options or provenance.
    pub fn open(
        root: &Path,
        options: CropOptions,
        provenance: Provenance,
    ) -> Result<Opened<Self>, StoreError> {
        let named = |text: &str| !text.is_empty() && !text.contains(char::is_control);
        let checks = [
            ("options.name", named(&options.name), json!(options.name), "a name of one line"),
            ("options.licence", named(&options.licence), json!(options.licence), "a name of one line"),
            (
                "options.samples_per_shard",
                options.samples_per_shard > 0,
                json!(options.samples_per_shard),
                "at least 1",
            ),
        ];
        for (field, holds, got, expected) in checks {
            require(holds, "manifest.json", field, got, expected).map_err(StoreError::unfit(root))?;
        }
        let opened = ShardedFolder::open(root, options.layout.name(), json!(options), provenance)?;
        Ok(opened.map(|folder| Self { folder, options, shard: None, batch: Vec::new() }))
    }

    /// Records the licence of an object's mesh; to be called before the object's first crop.
    pub fn add_licence(&mut self, instance: InstanceId, licence: &str) {
        let objects = &mut self.folder.manifest.objects;
        objects.entry(instance.to_string()).or_default().licence = Some(licence.to_owned());
    }

    /// Takes the next crop.
    ///
    /// # Errors
    /// [`StoreError::Unfit`] where a number is not finite or a name is not of one line, and [`StoreError::Write`].
    pub fn push(&mut self, sample: Sample) -> Result<(), StoreError> {
        check(&sample).map_err(StoreError::unfit(self.folder.root()))?;
        let per_shard = self.options.samples_per_shard;
        if self.shard.as_ref().is_some_and(|s| s.split != sample.split || s.samples == per_shard) {
            self.close_shard()?;
        }
        if self.batch.len() == BATCH {
            self.write_batch()?;
        }
        let shard = match self.shard.take() {
            Some(shard) => shard,
            None => {
                let created = Shard::create(&self.folder.work(), self.options.layout, sample.split);
                self.folder.written(created)?
            }
        };
        self.shard = Some(Shard { samples: shard.samples + 1, ..shard });
        self.batch.push(sample);
        Ok(())
    }

    /// Writes what is left and marks the dataset as finished.
    pub fn finish(mut self) -> Result<LayoutManifest, StoreError> {
        self.close_shard()?;
        let files = match self.options.layout {
            CropLayout::WebDataset => Vec::new(),
            #[cfg(feature = "parquet")]
            CropLayout::Parquet => {
                vec![("README.md".to_owned(), card(&self.options, &self.folder.manifest).into_bytes())]
            }
        };
        self.folder.finish(&files)
    }

    fn write_batch(&mut self) -> Result<(), StoreError> {
        let Some(shard) = &mut self.shard else { return Ok(()) };
        let rows: io::Result<Vec<Row>> =
            std::mem::take(&mut self.batch).into_par_iter().map(Row::encode).collect();
        let written = rows.and_then(|rows| match &mut shard.files {
            Files::WebDataset(tar) => rows.iter().try_for_each(|row| webdataset::add(tar, row)),
            #[cfg(feature = "parquet")]
            Files::Parquet(file) => file.add(&rows),
        });
        self.folder.written(written)
    }

    fn close_shard(&mut self) -> Result<(), StoreError> {
        self.write_batch()?;
        let Some(Shard { split, samples, files }) = self.shard.take() else { return Ok(()) };
        let closed = match files {
            Files::WebDataset(tar) => tar.close(),
            #[cfg(feature = "parquet")]
            Files::Parquet(file) => file.close(),
        };
        self.folder.written(closed)?;
        let index = self.folder.shards_of(split);
        let name = match self.options.layout {
            CropLayout::WebDataset => format!("{}-{index:06}.tar", split.name()),
            #[cfg(feature = "parquet")]
            CropLayout::Parquet => format!("data/{}-{index:05}.parquet", split.name()),
        };
        self.folder.commit(&name, split, samples)
    }
}

impl Shard {
    fn create(path: &Path, layout: CropLayout, split: Split) -> io::Result<Self> {
        let files = match layout {
            CropLayout::WebDataset => Files::WebDataset(TarShard::create(path)?),
            #[cfg(feature = "parquet")]
            CropLayout::Parquet => Files::Parquet(ParquetShard::create(path)?),
        };
        Ok(Self { split, samples: 0, files })
    }
}

fn check(sample: &Sample) -> Result<(), Fault> {
    let place = format!("sample {}", row::key(sample));
    let Camera { fx, fy, cx, cy, .. } = sample.camera;
    let corners = sample.bounding_box.min.iter().chain(&sample.bounding_box.max);
    let poses = [&sample.world_from_camera, &sample.object_from_camera].map(pose_fields);
    let viewpoint =
        sample.viewpoint.iter().flat_map(|v| v.direction.iter().chain([&v.roll, &v.log_distance]));
    let numbers = [&sample.timestamp, &fx, &fy, &cx, &cy].into_iter().chain(corners).chain(viewpoint);
    let stray = numbers.chain(poses.as_flattened()).find(|number| !number.is_finite());
    let shown = stray.map_or(json!(null), |number| json!(number.to_string()));
    let field = "timestamp, camera, box, poses and viewpoint";
    require(stray.is_none(), &place, field, shown, "finite numbers")?;
    let share = sample.visible_fraction;
    let shown = json!(share.to_string());
    require((0.0..=1.0).contains(&share), &place, "visible_fraction", shown, "in [0, 1]")?;
    let named = !sample.family.is_empty() && !sample.family.contains(char::is_control);
    require(named, &place, "family", json!(sample.family), "a name of one line")
}

fn require(
    holds: bool,
    place: &str,
    field: &str,
    got: serde_json::Value,
    expected: &str,
) -> Result<(), Fault> {
    if holds { Ok(()) } else { Err(Fault::new(place, None, field, got, expected)) }
}
