//! A sample as it is written, its images as PNG.

use crate::image_file::{CompressionType, Pixels, png};
use std::io;
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::{Crop, Sample};

/// A sample with its images as PNG.
pub(super) struct Row {
    pub(super) key: String,
    pub(super) masked: Vec<u8>,
    pub(super) boxed: Vec<u8>,
    pub(super) sample: Sample,
}

impl Row {
    pub(super) fn encode(sample: Sample) -> io::Result<Self> {
        let side = CROP_SIDE as u32;
        let png = |crop: &Crop| png(&Pixels::Rgb(&*crop.0), side, side, CompressionType::Fast);
        let (masked, boxed) = (png(&sample.masked_crop)?, png(&sample.boxed_crop)?);
        Ok(Self { key: key(&sample), masked, boxed, sample })
    }
}

/// Names a sample in its dataset.
pub(super) fn key(sample: &Sample) -> String {
    format!("{}-{:06}-{:04}", sample.episode, sample.step, sample.track)
}
