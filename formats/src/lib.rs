//! Our record <-> the formats that other programs read and write.
//!
//! | format | one sample | out | in | read by |
//! |---|---|---|---|---|
//! | WebDataset | a crop | [`CropWriter`] | | webdataset, Hugging Face datasets |
//! | Parquet | a crop | [`CropWriter`] | | Hugging Face datasets, pandas, polars |
//! | BOP, in folders or as WebDataset | an image | [`BopWriter`] | [`BopScenes`] (folders) | bop_toolkit and what follows it |
//! | BigBIRD (Singh et al. 2014) | an image of one object on a turntable | [`bigbird::BigBirdWriter`] | [`bigbird::read_objects`] | |
//! | Active Vision (Ammirato et al. 2017) | an image of a home, in a grid | [`avd::AvdWriter`] | [`avd::read_scan`] | |
//! | g2o | a pose graph | [`g2o::encode`] | | g2o, GTSAM, Ceres, SE-Sync |
//! | MH-iSAM2 (Hsiao & Kaess 2019) | an ambiguous measurement of the plane | | [`mh::read`] | |
//! | Mu et al. 2016 | a track among objects of the plane | | [`mu::read`] | |
//! | COIL-100's names (Nene et al. 1996) | a photograph from an azimuth | | [`read_turned_photos`] | |
//! | KITTI, EuRoC | a pose | | [`Trajectory::from_kitti`], [`Trajectory::from_euroc`] | |
//! | NPZ | an array | [`npz::Npz`] | | NumPy, evo |
//! | TUM | a pose | [`write_tum`](vantage_dataset::store::write_tum) | [`Trajectory::from_tum`] | evo, the TUM RGB-D tools |
//!
//! | module | what it holds |
//! |---|---|
//! | `crops` | WebDataset and Parquet: options, rows, writers, the card for Hugging Face |
//! | `bop` | BOP's annotations, meshes, scene folders and shards, and what reads them; `rle` are its masks |
//! | [`bigbird`], [`avd`] | each a reader, a writer and what both know of the files |
//! | [`mat5`], [`hdf5`], `picture`, `image_file` | files that several formats are made of |
//! | `shard` | a dataset written shard by shard, taken up where it was left, and its manifest |
//! | `import` | what a reader leaves out, and what stops it |
//! | `meeting`, `rigid`, `mean_pose`, `lens` | where lines of sight meet in spite of outliers; rotations from matrices; means; distortion |
//! | `level_robot` | the robot of recordings that know a camera alone |
//! | `principal_point` | intrinsics that are of another image |
//!
//! Writers take samples one by one. Those of crops and BOP hold no more than one shard of them; what a shard holds
//! depends on the samples and options alone: not on threads, and not on how often writing was interrupted. [`Opened`]
//! says how many samples a folder holds already. Readers trust nothing: they open regular files alone, read no more than
//! a limit of each, and tell what they leave out. See `docs/formats.md` and `docs/import.md` for every file and field.

pub mod avd;
#[cfg(feature = "hdf5")]
pub mod bigbird;
mod bop;
mod crops;
pub mod g2o;
#[cfg(feature = "hdf5")]
pub mod hdf5;
mod image_file;
mod import;
mod lens;
mod level_robot;
pub mod mat5;
mod mean_pose;
mod meeting;
pub mod mh;
pub mod mu;
pub mod npz;
mod picture;
mod pose_text;
mod principal_point;
mod rigid;
mod rle;
mod shard;
pub mod trajectory;
mod turned_photos;

#[cfg(test)]
#[cfg(feature = "parquet")]
mod tests;

pub use bop::{
    BopArrangement, BopLayout, BopOptions, BopScenes, BopWriter, DetectionLimits, MeshGeometry, ObjectModel,
    ReadModel, Scene, Silhouettes, Texture,
};
pub use crops::{CropLayout, CropOptions, CropWriter};
pub use import::{ImportError, ImportReport, Problem, Skipped};
pub use lens::Lens;
pub use pose_text::{PoseText, PoseTextError};
pub use shard::{
    FORMAT, Inventory, LayoutManifest, ObjectRecord, Opened, SET_ASIDE, ShardRecord, verify_layout,
};
pub use trajectory::{Trajectory, TrajectoryError, TumError};
pub use turned_photos::{Turntable, read_turned_photos};

use std::path::Path;
use vantage_dataset::ObjectTruth;
use vantage_dataset::store::StoreError;

/// The name of a simulated object in an exported dataset: its family and the 16 hexadecimal digits of its id.
pub fn object_name(object: &ObjectTruth) -> String {
    format!("{}_{}", object.family, object.instance)
}

/// Makes a folder, which must be empty if it is there.
fn make_empty(folder: &Path) -> Result<(), StoreError> {
    std::fs::create_dir_all(folder).map_err(StoreError::write(folder))?;
    let mut entries = std::fs::read_dir(folder).map_err(StoreError::read(folder))?;
    if entries.next().is_some() { Err(StoreError::Foreign { folder: folder.to_owned() }) } else { Ok(()) }
}
