//! NPZ: a zip archive of NumPy arrays, which `numpy.load` opens; evo's results are such archives, too.
//!
//! Members are stored as they are, without a time, so that equal arrays make equal bytes.

use std::io::{Cursor, Write};
use vantage_dataset::store::npy_header;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// The elements of an array, in C order.
#[derive(Clone, Copy, Debug)]
pub enum Elements<'a> {
    /// `<f8`.
    F64(&'a [f64]),
    /// `<f4`.
    F32(&'a [f32]),
    /// `<i8`.
    I64(&'a [i64]),
    /// `S`: bytes, as many as the longest text has.
    Text(&'a [&'a str]),
}

/// An archive under way.
pub struct Npz(ZipWriter<Cursor<Vec<u8>>>);

impl Npz {
    /// An empty one.
    #[expect(clippy::new_without_default, reason = "it is to be filled and finished")]
    pub fn new() -> Self {
        Self(ZipWriter::new(Cursor::new(Vec::new())))
    }

    /// Adds the array `name` of this shape.
    ///
    /// # Panics
    /// If the shape does not hold as many elements as there are, or as [`file`](Self::file) does.
    pub fn array(&mut self, name: &str, shape: &[usize], elements: Elements<'_>) {
        let (descr, bytes) = elements.bytes();
        assert_eq!(shape.iter().product::<usize>(), elements.len(), "{name}: {shape:?}");
        let mut member = npy_header(&descr, shape);
        member.extend(bytes);
        self.file(&format!("{name}.npy"), &member);
    }

    /// Adds a member that is no array.
    ///
    /// # Panics
    /// If there is one of this name, or it has 4 GiB.
    pub fn file(&mut self, name: &str, bytes: &[u8]) {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(0o644);
        let written =
            self.0.start_file(name, options).map_err(Into::into).and_then(|()| self.0.write_all(bytes));
        written.expect("memory takes a new member below 4 GiB");
    }

    /// The archive's bytes.
    pub fn finish(self) -> Vec<u8> {
        self.0.finish().expect("memory takes the directory").into_inner()
    }
}

impl Elements<'_> {
    fn len(&self) -> usize {
        match self {
            Self::F64(of) => of.len(),
            Self::F32(of) => of.len(),
            Self::I64(of) => of.len(),
            Self::Text(of) => of.len(),
        }
    }

    /// NumPy's name of the elements, and their bytes.
    fn bytes(&self) -> (String, Vec<u8>) {
        match self {
            Self::F64(of) => ("<f8".to_owned(), of.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Self::F32(of) => ("<f4".to_owned(), of.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Self::I64(of) => ("<i8".to_owned(), of.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Self::Text(of) => {
                let longest = of.iter().map(|text| text.len()).max().unwrap_or(0).max(1);
                let padded = |text: &&str| {
                    let mut bytes = text.as_bytes().to_vec();
                    bytes.resize(longest, 0);
                    bytes
                };
                (format!("|S{longest}"), of.iter().flat_map(padded).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use zip::ZipArchive;

    fn written() -> Vec<u8> {
        let mut npz = Npz::new();
        npz.array("x", &[2, 2], Elements::F64(&[1.0, f64::NAN, -0.5, 1e300]));
        npz.array("names", &[2], Elements::Text(&["mug", "b"]));
        npz.array("none", &[0, 3], Elements::F32(&[]));
        npz.file("info.json", b"{}");
        npz.finish()
    }

    #[test]
    fn members_are_arrays_as_numpy_writes_them() {
        let mut archive = ZipArchive::new(Cursor::new(written())).unwrap();
        let mut read = |name: &str| {
            let mut bytes = Vec::new();
            archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
            bytes
        };
        let x = read("x.npy");
        assert_eq!((&x[..8], x.len()), (&b"\x93NUMPY\x01\x00"[..], 128 + 32));
        let head = String::from_utf8_lossy(&x[10..128]).into_owned();
        assert!(head.starts_with("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }"), "{head}");
        assert_eq!(x[128..136], 1f64.to_le_bytes());
        let names = read("names.npy");
        assert!(String::from_utf8_lossy(&names).contains("'|S3', 'fortran_order': False, 'shape': (2,), }"));
        assert_eq!(names[128..], *b"mugb\0\0");
        assert_eq!((read("none.npy").len(), read("info.json")), (128, b"{}".to_vec()));
    }

    #[test]
    fn equal_arrays_make_equal_bytes() {
        assert_eq!(written(), written());
    }

    #[test]
    #[should_panic(expected = "x: [3]")]
    fn a_shape_of_other_elements_is_a_bug() {
        Npz::new().array("x", &[3], Elements::I64(&[1, 2]));
    }
}
