//! HDF5 files: numbers by name.

use super::import::{FETCH_AGAIN, ImportError, read_file};
use crate::store::StoreError;
use hdf5_pure::{File, FileBuilder};
use std::path::{Path, PathBuf};

const LARGEST_FILE: u64 = 64 << 20;

/// An open file.
pub(super) struct Hdf5 {
    path: PathBuf,
    file: File,
    names: Vec<String>,
}

impl Hdf5 {
    pub(super) fn open(path: &Path) -> Result<Self, ImportError> {
        let bytes = read_file(path, LARGEST_FILE)?;
        let unreadable =
            |error| ImportError::invalid(path, "file", error, "an HDF5 file that can be read", FETCH_AGAIN);
        let file = File::from_bytes(bytes).map_err(unreadable)?;
        let names = file.root().datasets().map_err(unreadable)?;
        Ok(Self { path: path.to_owned(), file, names })
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Finite numbers in a dataset of the root, row-major; none where there is no such dataset.
    pub(super) fn floats(&self, name: &str, shape: &[u64]) -> Result<Option<Vec<f64>>, ImportError> {
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
        match values.iter().find(|value| !value.is_finite()) {
            Some(stray) => Err(ImportError::invalid(&self.path, field, stray, "finite", FETCH_AGAIN)),
            None => Ok(Some(values)),
        }
    }

    /// [`Hdf5::floats`] of a dataset that must be there.
    pub(super) fn required(&self, name: &str, shape: &[u64]) -> Result<Vec<f64>, ImportError> {
        self.floats(name, shape)?.ok_or_else(|| {
            ImportError::invalid(&self.path, format!("/{name}"), "no such dataset", "a dataset", FETCH_AGAIN)
        })
    }
}

/// Writes datasets of `f64` with their shapes, in this order.
pub(super) fn write_floats(path: &Path, datasets: &[(String, Vec<f64>, Vec<u64>)]) -> Result<(), StoreError> {
    let mut builder = FileBuilder::new();
    for (name, values, shape) in datasets {
        builder.create_dataset(name).with_f64_data(values).with_shape(shape);
    }
    finish(path, builder)
}

/// Writes one dataset of `u16`, rows by columns.
pub(super) fn write_image(path: &Path, name: &str, values: &[u16], width: usize) -> Result<(), StoreError> {
    let mut builder = FileBuilder::new();
    let shape = [values.len() / width, width].map(|side| side as u64);
    builder.create_dataset(name).with_u16_data(values).with_shape(&shape);
    finish(path, builder)
}

fn finish(path: &Path, builder: FileBuilder) -> Result<(), StoreError> {
    let bytes = builder.finish().map_err(std::io::Error::other);
    bytes.and_then(|bytes| std::fs::write(path, bytes)).map_err(StoreError::write(path))
}
