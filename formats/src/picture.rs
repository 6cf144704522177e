//! Images in files.

use super::image_file::{CompressionType, Pixels, jpeg, png};
use super::import::{FETCH_AGAIN, ImportError, read_file};
#[cfg(feature = "hdf5")]
use image::GrayImage;
use image::{DynamicImage, ImageBuffer, ImageError, ImageFormat, ImageReader, Limits, Luma, RgbImage};
use std::io::Cursor;
use std::path::Path;
use vantage_dataset::store::StoreError;

const LARGEST_FILE: u64 = 64 << 20;
const LARGEST_SIDE: u32 = 1 << 14;
const LARGEST_IMAGE: u64 = 256 << 20;

/// Depth as whole numbers; what one of them is depends on the dataset.
pub(crate) type DepthImage = ImageBuffer<Luma<u16>, Vec<u16>>;

/// A JPEG that is whole: the decoder itself makes up what a file that is cut short lacks.
pub(crate) fn read_jpeg(path: &Path) -> Result<RgbImage, ImportError> {
    let bytes = read_file(path, LARGEST_FILE)?;
    let image = decode(path, &bytes, ImageFormat::Jpeg)?;
    if !vantage_dataset::jpeg::is_whole(&bytes) {
        let expected = "a marker of the image's end after its last scan";
        return Err(ImportError::invalid(path, "image", "a file that is cut short", expected, FETCH_AGAIN));
    }
    Ok(image.into_rgb8())
}

pub(crate) fn read_png(path: &Path) -> Result<RgbImage, ImportError> {
    let bytes = read_file(path, LARGEST_FILE)?;
    Ok(decode(path, &bytes, ImageFormat::Png)?.into_rgb8())
}

#[cfg(feature = "hdf5")]
/// A mask as it decodes: 0 where PBM says black.
pub(crate) fn read_pbm(path: &Path) -> Result<GrayImage, ImportError> {
    let bytes = read_file(path, LARGEST_FILE)?;
    Ok(decode(path, &bytes, ImageFormat::Pnm)?.into_luma8())
}

pub(crate) fn read_depth(path: &Path) -> Result<DepthImage, ImportError> {
    let bytes = read_file(path, LARGEST_FILE)?;
    match decode(path, &bytes, ImageFormat::Png)? {
        DynamicImage::ImageLuma16(depth) => Ok(depth),
        other => {
            let got = format!("{:?}", other.color());
            Err(ImportError::invalid(
                path,
                "pixels",
                got,
                "grey of 16 bits",
                "take the depth images unchanged",
            ))
        }
    }
}

fn decode(path: &Path, bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, ImportError> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    limits.max_alloc = Some(LARGEST_IMAGE);
    reader.limits(limits);
    reader.decode().map_err(|error| match error {
        ImageError::Limits(_) => {
            let expected =
                format!("at most {LARGEST_SIDE} pixels a side, and {} MiB decoded", LARGEST_IMAGE >> 20);
            ImportError::invalid(path, "image", "a larger one", expected, "make the image smaller")
        }
        error => ImportError::invalid(path, "image", error, format!("a {format:?} image"), FETCH_AGAIN),
    })
}

pub(crate) fn write_jpeg(path: &Path, rgb: &[u8], width: u32, height: u32) -> Result<(), StoreError> {
    let bytes = jpeg(rgb, width, height);
    bytes.and_then(|bytes| std::fs::write(path, bytes)).map_err(StoreError::write(path))
}

pub(crate) fn write_depth(path: &Path, depth: &[u16], width: u32, height: u32) -> Result<(), StoreError> {
    let bytes = png(&Pixels::Deep(depth), width, height, CompressionType::Default);
    bytes.and_then(|bytes| std::fs::write(path, bytes)).map_err(StoreError::write(path))
}

#[cfg(feature = "hdf5")]
/// Writes a raw PBM; `black` says which pixels are, row-major.
pub(crate) fn write_pbm(path: &Path, black: &[bool], width: usize) -> Result<(), StoreError> {
    let mut bytes = format!("P4\n{width} {}\n", black.len() / width).into_bytes();
    for row in black.chunks(width) {
        bytes.extend(row.chunks(8).map(|eight| {
            eight.iter().enumerate().fold(0, |byte, (bit, black)| byte | u8::from(*black) << (7 - bit))
        }));
    }
    std::fs::write(path, bytes).map_err(StoreError::write(path))
}
