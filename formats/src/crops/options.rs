//! What shapes a dataset of crops.

use serde::{Deserialize, Serialize};

/// In which files crops are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CropLayout {
    /// Tar archives of PNG and JSON files.
    WebDataset,
    #[cfg(feature = "parquet")]
    /// Parquet files with the images as PNG, and a README.md that tells Hugging Face of them.
    Parquet,
}

impl CropLayout {
    /// The layout's name in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::WebDataset => "webdataset",
            #[cfg(feature = "parquet")]
            Self::Parquet => "parquet",
        }
    }
}

/// What shapes a dataset of crops.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CropOptions {
    /// The files.
    pub layout: CropLayout,
    /// The dataset's name, one line.
    pub name: String,
    /// The dataset's licence as Hugging Face names it, such as `cc-by-4.0`.
    pub licence: String,
    /// The most crops in one shard, at least 1.
    pub samples_per_shard: u64,
}
