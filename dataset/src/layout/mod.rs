//! Datasets in the layouts that other programs read.
//!
//! | layout | one sample | written by | read by |
//! |---|---|---|---|
//! | `webdataset` | a crop | [`CropWriter`] | webdataset, Hugging Face datasets |
//! | `parquet` | a crop | [`CropWriter`] | Hugging Face datasets, pandas, polars |
//! | `bop` | an image | [`BopWriter`] | bop_toolkit and what follows it |
//! | `bop-webdataset` | an image | [`BopWriter`] | the same |
//!
//! Writers take samples one by one and hold no more than one shard of them. What a shard holds depends on the
//! samples and options alone: not on threads, and not on how often writing was interrupted. [`Opened`] says how many
//! samples a folder holds already. See `docs/formats.md` for every file and field.

mod bop;
mod crops;
mod image_file;
mod parquet;
mod rle;
mod shard;
mod webdataset;

#[cfg(test)]
mod tests;

pub use bop::{BopLayout, BopOptions, BopWriter, ObjectModel, Scene, Texture};
pub use crops::{CropLayout, CropOptions, CropWriter};
pub use rle::Rle;
pub use shard::{LayoutManifest, ObjectRecord, Opened, ShardRecord, verify_layout};
