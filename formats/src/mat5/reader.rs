//! Reads MAT-files.

use super::value::{StructArray, Value};
use super::{class, kind};
use crate::import::{FETCH_AGAIN, ImportError, read_file};
use flate2::read::ZlibDecoder;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

const HEADER: usize = 128;
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Largest file, and most that all its compressed variables may hold together, bytes.
const LARGEST: usize = 32 << 20;
/// How deep structs and cells may lie in each other.
const DEEPEST: usize = 16;
const MOST_DIMENSIONS: usize = 32;

/// Reads all variables of a MAT-file.
///
/// # Errors
///
/// A file that is not of version 5 to 7, is cut short, or holds more than 32 MiB.
pub fn read(path: &Path) -> Result<BTreeMap<String, Value>, ImportError> {
    decode(&read_file(path, LARGEST as u64)?, path)
}

/// [`read`] of the bytes of a file; `path` is for messages alone.
pub fn decode(bytes: &[u8], path: &Path) -> Result<BTreeMap<String, Value>, ImportError> {
    check_header(bytes, path)?;
    let mut elements = Elements { rest: &bytes[HEADER..], file: path, compressed_allowed: true };
    let mut variables = BTreeMap::new();
    let mut room = LARGEST;
    while !elements.rest.is_empty() {
        let (kind, body) = elements.next()?;
        let (name, value) = match kind {
            kind::MATRIX => elements.matrix(body, 0)?,
            kind::COMPRESSED => {
                let inflated = inflate(body, room, path)?;
                room -= inflated.len();
                let mut inner = Elements { rest: &inflated, file: path, compressed_allowed: false };
                match inner.next()? {
                    (kind::MATRIX, body) => inner.matrix(body, 0)?,
                    (other, _) => return Err(inner.fault("compressed element", other, "an array")),
                }
            }
            other => return Err(elements.fault("element", format!("kind {other}"), "an array")),
        };
        variables.insert(name, value);
    }
    Ok(variables)
}

fn check_header(bytes: &[u8], file: &Path) -> Result<(), ImportError> {
    let hdf5 = bytes.starts_with(HDF5_SIGNATURE)
        || bytes.starts_with(b"MATLAB 7.3")
        || bytes.get(512..).is_some_and(|rest| rest.starts_with(HDF5_SIGNATURE));
    if hdf5 {
        let remedy = "save it in MATLAB by save(..., '-v7')";
        return Err(ImportError::invalid(file, "version", "7.3 (HDF5)", "version 5, 6 or 7", remedy));
    }
    let expected = "a MAT-file of version 5, little-endian";
    match bytes.get(124..HEADER) {
        Some([0, 1, b'I', b'M']) => Ok(()),
        Some([1, 0, b'M', b'I']) => {
            let remedy = "save it anew on a machine of today";
            Err(ImportError::invalid(file, "byte order", "big-endian", expected, remedy))
        }
        Some(other) => Err(ImportError::invalid(file, "header", format!("{other:?}"), expected, FETCH_AGAIN)),
        None => {
            let got = format!("{} bytes", bytes.len());
            Err(ImportError::invalid(file, "header", got, expected, FETCH_AGAIN))
        }
    }
}

fn inflate(body: &[u8], room: usize, file: &Path) -> Result<Vec<u8>, ImportError> {
    let mut inflated = Vec::new();
    ZlibDecoder::new(body).take(room as u64 + 1).read_to_end(&mut inflated).map_err(|error| {
        ImportError::invalid(file, "compressed element", error, "data that inflate", FETCH_AGAIN)
    })?;
    if inflated.len() > room {
        let expected = format!("at most {} MiB when inflated", LARGEST >> 20);
        let remedy = "check that it is the right file";
        return Err(ImportError::invalid(file, "compressed element", "more", expected, remedy));
    }
    Ok(inflated)
}

/// Data elements, one behind the other.
struct Elements<'a> {
    rest: &'a [u8],
    file: &'a Path,
    /// Whether one of them may be compressed, and so need not be padded.
    compressed_allowed: bool,
}

impl<'a> Elements<'a> {
    fn within(&self, body: &'a [u8]) -> Elements<'a> {
        Elements { rest: body, file: self.file, compressed_allowed: false }
    }

    fn fault(
        &self,
        field: impl Into<String>,
        got: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> ImportError {
        ImportError::invalid(self.file, field, got, expected, FETCH_AGAIN)
    }

    /// Kind and body of the next element.
    fn next(&mut self) -> Result<(u32, &'a [u8]), ImportError> {
        let rest = self.rest;
        let (Some(first), Some(second)) = (word(rest, 0), word(rest, 4)) else {
            return Err(self.fault("element", format!("{} bytes left", rest.len()), "the 8 bytes of a tag"));
        };
        if first >> 16 != 0 {
            let (kind, length) = (first & 0xffff, (first >> 16) as usize);
            if length > 4 {
                return Err(self.fault("small element", format!("{length} bytes"), "at most 4"));
            }
            self.rest = &rest[8..];
            return Ok((kind, &rest[4..4 + length]));
        }
        let length = second as usize;
        let Some(body) = rest[8..].get(..length) else {
            let expected = format!("at most the {} that are left", rest.len() - 8);
            return Err(self.fault("element", format!("{length} bytes"), expected));
        };
        let unpadded = first == kind::COMPRESSED && self.compressed_allowed;
        let end = 8 + if unpadded { length } else { length.next_multiple_of(8) };
        self.rest = &rest[end.min(rest.len())..];
        Ok((first, body))
    }

    /// The next element, which has to be of one of these kinds.
    fn expect(&mut self, field: &str, kinds: &[u32]) -> Result<&'a [u8], ImportError> {
        let (kind, body) = self.next()?;
        if kinds.contains(&kind) {
            return Ok(body);
        }
        Err(self.fault(field, format!("kind {kind}"), format!("one of the kinds {kinds:?}")))
    }

    /// Name and value of an array.
    fn matrix(&self, body: &'a [u8], depth: usize) -> Result<(String, Value), ImportError> {
        if depth > DEEPEST {
            return Err(self.fault("array", "arrays in arrays", format!("at most {DEEPEST} deep")));
        }
        if body.is_empty() {
            return Ok((String::new(), Value::empty()));
        }
        let mut inner = self.within(body);
        let flags = inner.expect("array flags", &[kind::UINT32])?;
        let Some(flags) = word(flags, 0).filter(|_| flags.len() == 8) else {
            return Err(self.fault("array flags", format!("{} bytes", flags.len()), "8 bytes"));
        };
        let class = (flags & 0xff) as u8;
        if !matches!(class, class::CELL | class::STRUCT | class::CHAR | class::DOUBLE..=class::UINT64) {
            return Ok((inner.name_of_other(), Value::Other(class)));
        }
        let (dims, count) = inner.dimensions()?;
        let name = inner.expect("array name", &[kind::INT8, kind::UTF8, kind::UINT8])?;
        let name = String::from_utf8_lossy(name).into_owned();
        let value = match class {
            class::CELL => Value::Cells(inner.children(&name, count, depth)?),
            class::STRUCT => Value::Structs(inner.structs(&name, count, depth)?),
            class::CHAR => Value::Text(inner.text(&name)?),
            _ => Value::Numbers { data: inner.numbers(&name, count)?, dims },
        };
        Ok((name, value))
    }

    /// The name of an array of a class that is not read.
    fn name_of_other(&mut self) -> String {
        let name = self.next().and_then(|_| self.next()).map(|(_, name)| name).unwrap_or_default();
        String::from_utf8_lossy(name).into_owned()
    }

    fn dimensions(&mut self) -> Result<(Vec<usize>, usize), ImportError> {
        let body = self.expect("dimensions", &[kind::INT32, kind::UINT32])?;
        let dims: Vec<usize> = words(body).map(|extent| extent as usize).collect();
        let count = dims.iter().try_fold(1_usize, |count, extent| count.checked_mul(*extent));
        match count {
            Some(count) if dims.len() <= MOST_DIMENSIONS && count <= LARGEST => Ok((dims, count)),
            _ => Err(self.fault("dimensions", format!("{dims:?}"), format!("at most {LARGEST} places"))),
        }
    }

    fn numbers(&mut self, name: &str, count: usize) -> Result<Vec<f64>, ImportError> {
        let (kind, body) = self.next()?;
        let Some(numbers) = numbers_of(kind, body) else {
            return Err(self.fault(name, format!("kind {kind}"), "numbers"));
        };
        if numbers.len() != count {
            return Err(self.fault(name, format!("{} numbers", numbers.len()), format!("{count}")));
        }
        Ok(numbers)
    }

    fn text(&mut self, name: &str) -> Result<String, ImportError> {
        let (kind, body) = self.next()?;
        match kind {
            kind::UTF8 | kind::INT8 | kind::UINT8 => Ok(String::from_utf8_lossy(body).into_owned()),
            kind::UINT16 | kind::UTF16 => {
                let units: Vec<u16> =
                    body.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
                Ok(String::from_utf16_lossy(&units))
            }
            other => Err(self.fault(name, format!("kind {other}"), "characters")),
        }
    }

    fn structs(&mut self, name: &str, count: usize, depth: usize) -> Result<StructArray, ImportError> {
        let width = self.expect("length of field names", &[kind::INT32])?;
        let width = word(width, 0).filter(|width| *width > 0).ok_or_else(|| {
            self.fault(format!("{name}, length of field names"), format!("{width:?}"), "a positive number")
        })?;
        let names = self.expect("field names", &[kind::INT8, kind::UINT8, kind::UTF8])?;
        let fields: Vec<String> = names
            .chunks_exact(width as usize)
            .map(|field| {
                let end = field.iter().position(|byte| *byte == 0).unwrap_or(field.len());
                String::from_utf8_lossy(&field[..end]).into_owned()
            })
            .collect();
        let total = count.checked_mul(fields.len()).filter(|_| count == 0 || !fields.is_empty());
        let Some(total) = total else {
            return Err(self.fault(name, format!("{count} structs without fields"), "structs with fields"));
        };
        let mut values = self.children(name, total, depth)?.into_iter();
        let elements = (0..count).map(|_| values.by_ref().take(fields.len()).collect()).collect();
        Ok(StructArray { fields, elements })
    }

    /// The next `count` arrays.
    fn children(&mut self, name: &str, count: usize, depth: usize) -> Result<Vec<Value>, ImportError> {
        if count > self.rest.len() / 8 {
            let expected = format!("no more than {} bytes can hold", self.rest.len());
            return Err(self.fault(name, format!("{count} arrays"), expected));
        }
        let mut children = Vec::new();
        for _ in 0..count {
            let body = self.expect(name, &[kind::MATRIX])?;
            children.push(self.matrix(body, depth + 1)?.1);
        }
        Ok(children)
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(4).map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}

/// Stored numbers, or none where `kind` is none of numbers.
fn numbers_of(kind: u32, body: &[u8]) -> Option<Vec<f64>> {
    fn all<const N: usize>(body: &[u8], decode: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        body.as_chunks::<N>().0.iter().map(|bytes| decode(*bytes)).collect()
    }
    Some(match kind {
        kind::INT8 => all(body, |bytes| f64::from(i8::from_le_bytes(bytes))),
        kind::UINT8 => all(body, |bytes| f64::from(u8::from_le_bytes(bytes))),
        kind::INT16 => all(body, |bytes| f64::from(i16::from_le_bytes(bytes))),
        kind::UINT16 => all(body, |bytes| f64::from(u16::from_le_bytes(bytes))),
        kind::INT32 => all(body, |bytes| f64::from(i32::from_le_bytes(bytes))),
        kind::UINT32 => all(body, |bytes| f64::from(u32::from_le_bytes(bytes))),
        kind::SINGLE => all(body, |bytes| f64::from(f32::from_le_bytes(bytes))),
        kind::DOUBLE => all(body, f64::from_le_bytes),
        kind::INT64 => all(body, |bytes| i64::from_le_bytes(bytes) as f64),
        kind::UINT64 => all(body, |bytes| u64::from_le_bytes(bytes) as f64),
        _ => return None,
    })
}
