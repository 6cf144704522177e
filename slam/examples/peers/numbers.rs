//! Files of little-endian doubles.

use crate::Failure;
use nalgebra::{DMatrix, Quaternion, Translation3, UnitQuaternion};
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use vantage_dataset::Pose;

/// A file being written.
pub struct Numbers(BufWriter<File>);

impl Numbers {
    /// An empty file.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        Ok(Self(BufWriter::new(File::create(path)?)))
    }

    /// Writes numbers.
    pub fn put(&mut self, numbers: &[f64]) -> Result<(), Failure> {
        numbers.iter().try_for_each(|number| self.0.write_all(&number.to_le_bytes()))?;
        Ok(())
    }

    /// Writes translation, then the quaternion with its real part last.
    pub fn put_pose(&mut self, pose: &Pose) -> Result<(), Failure> {
        self.put(pose.translation.vector.as_slice())?;
        self.put(pose.rotation.coords.as_slice())
    }

    /// Writes what waits.
    pub fn finish(mut self) -> Result<(), Failure> {
        Ok(self.0.flush()?)
    }
}

/// A file being read.
pub struct Source(BufReader<File>);

impl Source {
    /// From the start of a file.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        Ok(Self(BufReader::new(File::open(path)?)))
    }

    /// The next numbers.
    pub fn take(&mut self, n: usize) -> Result<Vec<f64>, Failure> {
        let mut bytes = vec![0; 8 * n];
        self.0.read_exact(&mut bytes)?;
        let (numbers, _) = bytes.as_chunks::<8>();
        Ok(numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    }

    /// A whole number.
    pub fn take_count(&mut self) -> Result<usize, Failure> {
        Ok(self.take(1)?[0] as usize)
    }

    /// A pose.
    pub fn take_pose(&mut self) -> Result<Pose, Failure> {
        Ok(pose(&self.take(7)?))
    }

    /// A matrix, column by column.
    pub fn take_matrix(&mut self, rows: usize, columns: usize) -> Result<DMatrix<f64>, Failure> {
        Ok(DMatrix::from_vec(rows, columns, self.take(rows * columns)?))
    }
}

/// Translation, then the quaternion with its real part last.
pub fn pose(numbers: &[f64]) -> Pose {
    let rotation = Quaternion::new(numbers[6], numbers[3], numbers[4], numbers[5]);
    let translation = Translation3::new(numbers[0], numbers[1], numbers[2]);
    Pose::from_parts(translation, UnitQuaternion::new_normalize(rotation))
}
