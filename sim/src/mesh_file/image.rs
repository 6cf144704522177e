//! Images of untrusted size.

use super::MeshFault;
use super::files::Files;
use image::{ImageFormat, ImageReader, Limits, RgbImage};
use std::io::{self, Cursor};
use vantage_dataset::jpeg;

/// Greatest width and height of an image, pixels.
const MAX_SIDE: u32 = 8192;
/// Most memory that decoding an image may take, bytes.
const MAX_DECODED_BYTES: u64 = 512 << 20;
/// Of a usual image, bytes.
const PIXEL_BYTES: u64 = 4;

/// Decodes a PNG or JPEG; transparency is dropped.
pub(crate) fn decode(files: &mut Files<'_>, bytes: &[u8], name: &str) -> Result<RgbImage, MeshFault> {
    let invalid = |reason: String| MeshFault::Image { name: name.to_owned(), reason };
    let reader = || ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    // What cannot be decoded has no size.
    if let Ok((width, height)) =
        reader().and_then(|reader| reader.into_dimensions().map_err(io::Error::other))
    {
        files.expect(PIXEL_BYTES * u64::from(width.min(MAX_SIDE)) * u64::from(height.min(MAX_SIDE)));
    }
    let mut reader = reader().map_err(|e| invalid(e.to_string()))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err(invalid("expected PNG or JPEG".to_owned()));
    }
    if reader.format() == Some(ImageFormat::Jpeg) && !jpeg::is_whole(bytes) {
        return Err(invalid("it is cut short, expected the image's end after its last scan".to_owned()));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    let image = reader
        .decode()
        .map_err(|error| invalid(format!("{error} (at most {MAX_SIDE} pixels a side are read)")))?
        .into_rgb8();
    if image.is_empty() { Err(invalid("it has no pixel".to_owned())) } else { Ok(image) }
}
