//! HDF5 files: numbers by name.

use super::import::{FETCH_AGAIN, ImportError, read_file};
use hdf5_pure::{File, FileBuilder};
use std::path::{Path, PathBuf};
use vantage_dataset::store::StoreError;

const LARGEST_FILE: u64 = 64 << 20;

/// An open file.
pub struct Hdf5 {
    path: PathBuf,
    file: File,
    names: Vec<String>,
}

impl Hdf5 {
    /// Opens a file of at most 64 MiB.
    pub fn open(path: &Path) -> Result<Self, ImportError> {
        Self::decode(read_file(path, LARGEST_FILE)?, path)
    }

    /// The file with these bytes; `path` is for messages alone.
    pub fn decode(bytes: Vec<u8>, path: &Path) -> Result<Self, ImportError> {
        let unreadable =
            |error| ImportError::invalid(path, "file", error, "an HDF5 file that can be read", FETCH_AGAIN);
        let file = File::from_bytes(bytes).map_err(unreadable)?;
        let names = file.root().datasets().map_err(unreadable)?;
        Ok(Self { path: path.to_owned(), file, names })
    }

    /// The names of the root's datasets.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Finite numbers in a dataset of the root, row-major; none where there is no such dataset.
    pub fn floats(&self, name: &str, shape: &[u64]) -> Result<Option<Vec<f64>>, ImportError> {
        if !self.names.iter().any(|known| known == name) {
            return Ok(None);
        }
        let field = format!("/{name}");
        let unreadable = |error| {
            ImportError::invalid(&self.path, field.clone(), error, "numbers that can be read", FETCH_AGAIN)
        };
        let dataset = self.file.dataset(name).map_err(unreadable)?;
        let got = dataset.shape().map_err(unreadable)?;
        if got != shape {
            let got = format!("shape {got:?}");
            let expected = format!("shape {shape:?}");
            return Err(ImportError::invalid(&self.path, field, got, expected, FETCH_AGAIN));
        }
        let values = dataset.read_f64().map_err(unreadable)?;
        // A damaged file may hold fewer numbers, or more, than its shape says.
        if values.len() as u64 != shape.iter().product::<u64>() {
            let (got, expected) = (format!("{} numbers", values.len()), format!("those of shape {shape:?}"));
            return Err(ImportError::invalid(&self.path, field, got, expected, FETCH_AGAIN));
        }
        match values.iter().find(|value| !value.is_finite()) {
            Some(stray) => Err(ImportError::invalid(&self.path, field, stray, "finite", FETCH_AGAIN)),
            None => Ok(Some(values)),
        }
    }

    /// [`Hdf5::floats`] of a dataset that must be there.
    pub fn required(&self, name: &str, shape: &[u64]) -> Result<Vec<f64>, ImportError> {
        self.floats(name, shape)?.ok_or_else(|| {
            ImportError::invalid(&self.path, format!("/{name}"), "no such dataset", "a dataset", FETCH_AGAIN)
        })
    }
}

/// Writes datasets of `f64` with their shapes, in this order.
pub(crate) fn write_floats(path: &Path, datasets: &[(String, Vec<f64>, Vec<u64>)]) -> Result<(), StoreError> {
    let mut builder = FileBuilder::new();
    for (name, values, shape) in datasets {
        builder.create_dataset(name).with_f64_data(values).with_shape(shape);
    }
    finish(path, builder)
}

/// Writes one dataset of `u16`, rows by columns.
pub(crate) fn write_image(path: &Path, name: &str, values: &[u16], width: usize) -> Result<(), StoreError> {
    let mut builder = FileBuilder::new();
    let shape = [values.len() / width, width].map(|side| side as u64);
    builder.create_dataset(name).with_u16_data(values).with_shape(&shape);
    finish(path, builder)
}

fn finish(path: &Path, builder: FileBuilder) -> Result<(), StoreError> {
    let bytes = builder.finish().map_err(std::io::Error::other);
    bytes.and_then(|bytes| std::fs::write(path, bytes)).map_err(StoreError::write(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_a_byte_is_there_are_as_many_numbers_as_the_shape_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.h5");
        let numbers: Vec<f64> = (0..16).map(f64::from).collect();
        let distortion = vec![0.5; 5];
        let datasets =
            [("H".to_owned(), numbers.clone(), vec![4, 4]), ("d".to_owned(), distortion.clone(), vec![5])];
        write_floats(&path, &datasets).unwrap();
        let read = |bytes: &[u8], name: &str, shape: &[u64]| {
            Hdf5::decode(bytes.to_vec(), &path).and_then(|file| file.floats(name, shape))
        };
        let whole = std::fs::read(&path).unwrap();
        assert_eq!(read(&whole, "H", &[4, 4]).unwrap(), Some(numbers));
        assert_eq!(read(&whole, "d", &[5]).unwrap(), Some(distortion));
        let mut refused = 0;
        for at in 0..whole.len() {
            for byte in [0, 1, 2, 6, 0x7f, 0xff] {
                let mut damaged = whole.clone();
                damaged[at] = byte;
                for (name, shape, count) in [("H", &[4, 4][..], 16), ("d", &[5], 5)] {
                    match read(&damaged, name, shape) {
                        Ok(read) => assert!(read.is_none_or(|read| read.len() == count), "{at} {byte}"),
                        Err(_) => refused += 1,
                    }
                }
            }
        }
        assert!(refused > 100, "{refused}");
    }
}
