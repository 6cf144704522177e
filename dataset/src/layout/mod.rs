//! Datasets in the layouts that other programs read and write.
//!
//! | layout | one sample | written by | read by |
//! |---|---|---|---|
//! | `webdataset` | a crop | [`CropWriter`] | webdataset, Hugging Face datasets |
//! | `parquet` | a crop | [`CropWriter`] | Hugging Face datasets, pandas, polars |
//! | `bop` | an image | [`BopWriter`] | bop_toolkit and what follows it |
//! | `bop-webdataset` | an image | [`BopWriter`] | the same |
//! | BigBIRD (Singh et al. 2014) | an image of one object on a turntable | [`bigbird::BigBirdWriter`] | [`bigbird::read_objects`] |
//! | Active Vision (Ammirato et al. 2017) | an image of a home, in a grid | [`avd::AvdWriter`] | [`avd::read_scan`] |
//!
//! Writers take samples one by one. Those of the first four hold no more than one shard of them; what a shard holds depends
//! on the samples and options alone: not on threads, and not on how often writing was interrupted. [`Opened`] says how many
//! samples a folder holds already. See `docs/formats.md` and `docs/import.md` for every file and field.

pub mod avd;
pub mod bigbird;
mod bop;
mod crops;
mod hdf5;
mod image_file;
mod import;
mod lens;
pub mod mat5;
mod parquet;
mod picture;
mod ray;
mod rle;
mod shard;
mod webdataset;

#[cfg(test)]
mod tests;

pub use bop::{BopLayout, BopOptions, BopWriter, ObjectModel, Scene, Texture};
pub use crops::{CropLayout, CropOptions, CropWriter};
pub use import::{ImportError, ImportReport, Problem, Skipped};
pub use lens::Lens;
pub use rle::Rle;
pub use shard::{Inventory, LayoutManifest, ObjectRecord, Opened, SET_ASIDE, ShardRecord, verify_layout};

use crate::ObjectTruth;
use crate::store::StoreError;
use std::path::Path;

/// The name of a simulated object in an exported dataset: its family and the 16 hexadecimal digits of its id.
pub fn object_name(object: &ObjectTruth) -> String {
    format!("{}_{:016x}", object.family, object.instance.0)
}

/// Makes a folder, which must be empty if it is there.
fn make_empty(folder: &Path) -> Result<(), StoreError> {
    std::fs::create_dir_all(folder).map_err(StoreError::write(folder))?;
    let mut entries = std::fs::read_dir(folder).map_err(StoreError::read(folder))?;
    if entries.next().is_some() { Err(StoreError::Foreign { folder: folder.to_owned() }) } else { Ok(()) }
}
