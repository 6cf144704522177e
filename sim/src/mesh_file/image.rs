//! Images of untrusted size.

use super::MeshFault;
use image::{ImageFormat, ImageReader, Limits, RgbImage};
use std::io::Cursor;
use vantage_dataset::jpeg;

/// Greatest width and height of an image, pixels.
const MAX_SIDE: u32 = 8192;
/// Most memory that decoding an image may take, bytes.
const MAX_DECODED_BYTES: u64 = 512 << 20;

/// Decodes a PNG or JPEG; transparency is dropped.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<RgbImage, MeshFault> {
    let invalid = |reason: String| MeshFault::Image { name: name.to_owned(), reason };
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| invalid(e.to_string()))?;
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
