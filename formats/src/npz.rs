//! NPZ: a zip archive of NumPy arrays, which `numpy.load` opens; evo's results are such archives, too.
//!
//! Members are stored as they are, without a time, so that equal arrays make equal bytes.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use vantage_dataset::store::npy_header;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// How many elements are turned to bytes at a time.
const CHUNK: usize = 8192;

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

/// An archive under way, in a file: each array goes there before the next is added.
pub struct Npz(ZipWriter<BufWriter<File>>);

impl Npz {
    /// An empty one at `path`, in place of what is there.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self(ZipWriter::new(BufWriter::new(File::create(path)?))))
    }

    /// Adds the array `name` of this shape.
    ///
    /// # Panics
    /// If the shape does not hold as many elements as there are.
    pub fn array(&mut self, name: &str, shape: &[usize], elements: Elements<'_>) -> io::Result<()> {
        assert_eq!(shape.iter().product::<usize>(), elements.len(), "{name}: {shape:?}");
        let (descr, width) = elements.descr();
        let header = npy_header(&descr, shape);
        self.start(&format!("{name}.npy"), header.len() + width * elements.len())?;
        self.0.write_all(&header)?;
        elements.write(width, &mut self.0)
    }

    /// Adds a member that is no array.
    pub fn file(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        self.start(name, bytes.len())?;
        self.0.write_all(bytes)
    }

    /// Ends the archive; its bytes are on disk then.
    pub fn finish(self) -> io::Result<()> {
        let mut file = self.0.finish()?;
        file.flush()?;
        file.get_ref().sync_all()
    }

    fn start(&mut self, name: &str, bytes: usize) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .large_file(bytes as u64 >= u64::from(u32::MAX))
            .unix_permissions(0o644);
        Ok(self.0.start_file(name, options)?)
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

    /// NumPy's name of the elements, and the bytes of each.
    fn descr(&self) -> (String, usize) {
        match self {
            Self::F64(_) => ("<f8".to_owned(), 8),
            Self::F32(_) => ("<f4".to_owned(), 4),
            Self::I64(_) => ("<i8".to_owned(), 8),
            Self::Text(of) => {
                let longest = of.iter().map(|text| text.len()).max().unwrap_or(0).max(1);
                (format!("|S{longest}"), longest)
            }
        }
    }

    /// Writes them, some at a time.
    fn write(&self, width: usize, to: &mut impl Write) -> io::Result<()> {
        match self {
            Self::F64(of) => chunks(of, to, |x, bytes| bytes.extend(x.to_le_bytes())),
            Self::F32(of) => chunks(of, to, |x, bytes| bytes.extend(x.to_le_bytes())),
            Self::I64(of) => chunks(of, to, |x, bytes| bytes.extend(x.to_le_bytes())),
            Self::Text(of) => chunks(of, to, |text, bytes| {
                bytes.extend(text.as_bytes());
                bytes.extend(std::iter::repeat_n(0, width - text.len()));
            }),
        }
    }
}

fn chunks<T>(of: &[T], to: &mut impl Write, add: impl Fn(&T, &mut Vec<u8>)) -> io::Result<()> {
    let mut bytes = Vec::new();
    for chunk in of.chunks(CHUNK) {
        bytes.clear();
        chunk.iter().for_each(|element| add(element, &mut bytes));
        to.write_all(&bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Read};
    use zip::ZipArchive;

    fn written() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let mut npz = Npz::create(&path).unwrap();
        npz.array("x", &[2, 2], Elements::F64(&[1.0, f64::NAN, -0.5, 1e300])).unwrap();
        npz.array("names", &[2], Elements::Text(&["mug", "b"])).unwrap();
        npz.array("none", &[0, 3], Elements::F32(&[])).unwrap();
        let numbers: Vec<i64> = (0..2 * CHUNK as i64 + 1).collect();
        npz.array("many", &[numbers.len()], Elements::I64(&numbers)).unwrap();
        npz.file("info.json", b"{}").unwrap();
        npz.finish().unwrap();
        std::fs::read(path).unwrap()
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
        let many = read("many.npy");
        let last = (2 * CHUNK as i64).to_le_bytes();
        assert_eq!((many.len(), &many[many.len() - 8..]), (128 + 8 * (2 * CHUNK + 1), &last[..]));
        assert_eq!((read("none.npy").len(), read("info.json")), (128, b"{}".to_vec()));
    }

    #[test]
    fn equal_arrays_make_equal_bytes() {
        assert_eq!(written(), written());
    }

    #[test]
    #[should_panic(expected = "x: [3]")]
    fn a_shape_of_other_elements_is_a_bug() {
        let folder = tempfile::tempdir().unwrap();
        let mut npz = Npz::create(&folder.path().join("a.npz")).unwrap();
        let _ = npz.array("x", &[3], Elements::I64(&[1, 2]));
    }
}
