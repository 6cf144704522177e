//! Images as the bytes of a file.

use image::codecs::jpeg::JpegEncoder;
pub(crate) use image::codecs::png::CompressionType;
use image::codecs::png::{FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use std::io;

const JPEG_QUALITY: u8 = 95;

/// Pixels of one image, row-major and interleaved.
pub(crate) enum Pixels<'a> {
    /// sRGB.
    Rgb(&'a [u8]),
    /// sRGB and coverage.
    Rgba(&'a [u8]),
    /// 8 bits.
    Grey(&'a [u8]),
    /// 16 bits.
    Deep(&'a [u16]),
}

/// The bytes of a PNG, the same for equal pixels.
///
/// `Fast` takes a fifteenth of the time of `Default` for a crop and 7% more bytes, but for masks and depth it takes ten
/// times the bytes.
pub(crate) fn png(
    pixels: &Pixels<'_>,
    width: u32,
    height: u32,
    compression: CompressionType,
) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let filter = match pixels {
        Pixels::Grey(_) => FilterType::NoFilter,
        _ => FilterType::Adaptive,
    };
    let encoder = PngEncoder::new_with_quality(&mut bytes, compression, filter);
    let written = match pixels {
        Pixels::Rgb(rgb) => encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8),
        Pixels::Rgba(rgba) => encoder.write_image(rgba, width, height, ExtendedColorType::Rgba8),
        Pixels::Grey(grey) => encoder.write_image(grey, width, height, ExtendedColorType::L8),
        Pixels::Deep(deep) => {
            let samples: Vec<u8> = deep.iter().flat_map(|value| value.to_ne_bytes()).collect();
            encoder.write_image(&samples, width, height, ExtendedColorType::L16)
        }
    };
    written.map_err(io_error)?;
    Ok(bytes)
}

/// The bytes of a JPEG of nearly the same pixels.
pub(crate) fn jpeg(rgb: &[u8], width: u32, height: u32) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
    encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8).map_err(io_error)?;
    Ok(bytes)
}

fn io_error(error: ImageError) -> io::Error {
    match error {
        ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
