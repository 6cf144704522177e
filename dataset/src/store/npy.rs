//! NumPy arrays, format 1.0, C order; of crops `uint8 [n, 32, 32, 3]`.

use super::error::{Fault, StoreError};
use super::hashed_file::{Sink, Source};
use crate::crop::{CROP_BYTES, CROP_SIDE, Crop};
use std::io::{self, Read, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"\x93NUMPY\x01\x00";
/// NumPy pads magic, length and header to a multiple of this.
const ALIGNMENT: usize = 64;

/// The header of an array, to the byte as `numpy.save` writes it; `descr` is NumPy's name of its elements, as `<f8`.
pub fn npy_header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    let dictionary =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}{comma}), }}", lengths.join(", "));
    let unpadded = MAGIC.len() + 2 + dictionary.len() + 1;
    let padding = unpadded.next_multiple_of(ALIGNMENT) - unpadded;
    let length = (dictionary.len() + padding + 1) as u16;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(dictionary.as_bytes());
    bytes.extend(std::iter::repeat_n(b' ', padding));
    bytes.push(b'\n');
    bytes
}

fn header(crops: usize) -> Vec<u8> {
    npy_header("|u1", &[crops, CROP_SIDE, CROP_SIDE, 3])
}

/// Writes the crops in order.
pub(super) fn write_crops<'a>(
    sink: &mut Sink,
    crops: impl ExactSizeIterator<Item = &'a Crop>,
) -> io::Result<()> {
    sink.write_all(&header(crops.len()))?;
    crops.into_iter().try_for_each(|crop| sink.write_all(&*crop.0))
}

/// Reads the `n` crops that a file of `bytes` bytes must hold.
pub(super) fn read_crops(
    source: &mut Source,
    folder: &Path,
    name: &str,
    bytes: u64,
    n: usize,
) -> Result<Vec<Crop>, StoreError> {
    let expected = header(n);
    let mut found = vec![0; expected.len().min(usize::try_from(bytes).unwrap_or(usize::MAX))];
    source.read_exact(&mut found).map_err(StoreError::read(&folder.join(name)))?;
    let invalid = |field: &str, got: String, expected: String| {
        StoreError::invalid(folder)(Fault::new(name, None, field, got, expected))
    };
    if found != expected {
        let (got, expected) = (printable(&found), printable(&expected));
        return Err(invalid("header", got, format!("{expected} (one crop a row of the table)")));
    }
    let size = expected.len() as u128 + n as u128 * CROP_BYTES as u128;
    if u128::from(bytes) != size {
        return Err(invalid("length", format!("{bytes} bytes"), format!("{size} bytes")));
    }
    let mut crops = Vec::with_capacity(n);
    for _ in 0..n {
        let mut crop = Crop::black();
        source.read_exact(&mut *crop.0).map_err(StoreError::read(&folder.join(name)))?;
        crops.push(crop);
    }
    Ok(crops)
}

fn printable(header: &[u8]) -> String {
    let dictionary = header.get(MAGIC.len() + 2..).unwrap_or(header);
    format!("{:?}", String::from_utf8_lossy(dictionary).trim_end())
}
