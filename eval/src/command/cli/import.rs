//! Options of `bench import`.

use super::choice::{elevation, sizes};
use super::{ImportLayout, SplitChoice};
use clap::Args;
use clap::builder::RangedI64ValueParser;
use serde::Serialize;
use std::path::PathBuf;

/// `bench import LAYOUT DIR --out DIR`: real data in our own layout.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct ImportArgs {
    /// The layout of the data.
    #[arg(value_enum, value_name = "LAYOUT")]
    pub layout: ImportLayout,
    /// BigBIRD: the folder of the objects' folders. Active Vision: the folder of one scan. BOP: the dataset's folder, that of a split, or
    /// that of one scene. Folder: that of the photographs.
    #[arg(value_name = "DIR")]
    pub source: PathBuf,
    /// Folder that gets a view set (BigBIRD, a folder, or with `--views`), an episode (Active Vision), or a folder for each episode
    /// (BOP, or with `--like`).
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Active Vision, BOP: the detections as a view set, which `bench train --views` reads, in place of episodes.
    #[arg(long)]
    pub views: bool,
    /// Of a view set: the split that all objects are said to belong to.
    /// `train` where it is not given.
    #[arg(long, value_enum)]
    pub split: Option<SplitChoice>,
    /// Of a view set: only these objects, separated by commas.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Active Vision, BOP: the scene whose odometry's noise is added to the true motion; of BOP its detector's limits are those of
    /// detections, too. A file, or the name of one that comes with the program.
    #[arg(long, value_name = "SCENE")]
    pub like: Option<PathBuf>,
    /// How often the noise is drawn: episodes of one way, alike but for their odometry. Of a view set it is drawn once.
    #[arg(long, value_name = "N", requires = "like", conflicts_with = "views", default_value_t = 1, allow_negative_numbers = true, value_parser = RangedI64ValueParser::<u64>::new().range(1..=1000))]
    pub draws: u64,
    /// Folder of what comes with the program.
    #[arg(long, value_name = "DIR", default_value = "cache")]
    pub cache: PathBuf,
    /// Folder: elevation of the camera, degrees.
    /// 25 where it is not given.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = elevation)]
    pub elevation_deg: Option<f64>,
    /// Folder: distance of the camera, in sizes of the object.
    /// 5 where it is not given.
    #[arg(long, value_name = "SIZES", allow_negative_numbers = true, value_parser = sizes)]
    pub distance: Option<f64>,
    /// Folder: azimuths grow clockwise, seen from above.
    #[arg(long)]
    pub clockwise: bool,
}
