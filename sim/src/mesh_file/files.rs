//! The files that make up one mesh.

use super::find::{Source, file_name};
use super::turn::{LIGHT, Turn};
use super::{MeshFault, MeshFileError};
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use vantage_dataset::store::open_regular;

/// Most that is read of all files of a mesh together, bytes.
const MAX_BYTES: u64 = 256 << 20;
/// What a file's text becomes in memory, copies and triangles among it, in parts of its length.
const UNPACKED: u64 = 4;

/// Reads the files of one mesh and nothing outside its folder.
pub(crate) struct Files<'a> {
    source: &'a Source,
    /// Canonical path that everything lies under.
    root: PathBuf,
    hasher: blake3::Hasher,
    /// Bytes that may still be read.
    left: u64,
    /// Files that the mesh named, in the order in which they were read.
    names: Vec<String>,
    /// Bytes of memory that reading the mesh takes, as far as it is known.
    expected: u64,
    turn: Option<Turn>,
}

impl<'a> Files<'a> {
    pub fn new(source: &'a Source) -> Result<Self, MeshFileError> {
        let root = fs::canonicalize(&source.root).map_err(|e| source.error(MeshFault::Unreadable(e)))?;
        Ok(Self {
            source,
            root,
            hasher: blake3::Hasher::new(),
            left: MAX_BYTES,
            names: Vec::new(),
            expected: 0,
            turn: None,
        })
    }

    /// This mesh cannot be used.
    pub fn error(&self, fault: MeshFault) -> MeshFileError {
        self.source.error(fault)
    }

    /// The mesh file itself.
    pub fn main(&mut self) -> Result<Vec<u8>, MeshFileError> {
        self.take(&self.source.file.clone(), &file_name(&self.source.file)).map_err(|failure| match failure {
            Failure::System(error) => self.error(MeshFault::Unreadable(error)),
            Failure::Fault(fault) => self.error(fault),
        })
    }

    /// A file that the mesh names, relative to the mesh file.
    pub fn read(&mut self, name: &str) -> Result<Vec<u8>, MeshFileError> {
        let portable = name.replace('\\', "/");
        let absolute = portable.starts_with('/') || portable.as_bytes().get(1) == Some(&b':');
        if absolute {
            return Err(self.error(MeshFault::OutsideFolder { name: name.to_owned() }));
        }
        let missing = |source| MeshFault::MissingFile { name: name.to_owned(), source };
        let beside = self.source.file.with_file_name("").join(&portable);
        let elsewhere = self.source.textures.as_ref().map(|folder| folder.join(&portable));
        let path = match (fs::canonicalize(&beside), elsewhere) {
            (Err(error), Some(path)) if error.kind() == io::ErrorKind::NotFound => fs::canonicalize(path),
            (found, _) => found,
        };
        let path = path.map_err(|error| self.error(missing(error)))?;
        if !path.starts_with(&self.root) {
            return Err(self.error(MeshFault::OutsideFolder { name: name.to_owned() }));
        }
        let bytes = self.take(&path, name).map_err(|failure| match failure {
            Failure::System(error) => self.error(missing(error)),
            Failure::Fault(fault) => self.error(fault),
        })?;
        self.names.push(name.to_owned());
        Ok(bytes)
    }

    /// Waits for its turn where the mesh takes much memory, of which so many more bytes are about to be taken.
    pub fn expect(&mut self, bytes: u64) {
        self.expected = self.expected.saturating_add(bytes);
        if self.expected > LIGHT && self.turn.is_none() {
            self.turn = Some(Turn::wait());
        }
    }

    /// Hash of everything that was read, in the order in which it was read.
    pub fn hash(&self) -> blake3::Hash {
        self.hasher.finalize()
    }

    /// Hash as it would be after these files, which are read and forgotten.
    pub fn hash_with(&mut self, names: &[String]) -> Result<blake3::Hash, MeshFileError> {
        let (hasher, left, known) = (self.hasher.clone(), self.left, self.names.len());
        let read = names.iter().try_for_each(|name| self.read(name).map(drop));
        let hash = self.hash();
        (self.hasher, self.left) = (hasher, left);
        self.names.truncate(known);
        read.map(|()| hash)
    }

    /// Files that the mesh named, in the order in which they were read.
    pub fn names(self) -> Vec<String> {
        self.names
    }

    fn take(&mut self, path: &Path, name: &str) -> Result<Vec<u8>, Failure> {
        let file = open_regular(path)?;
        let length = file.metadata()?.len();
        let too_large = |bytes| MeshFault::FileTooLarge { name: name.to_owned(), bytes, limit: MAX_BYTES };
        if length > self.left {
            return Err(Failure::Fault(too_large(length)));
        }
        self.expect(UNPACKED * length);
        let mut bytes = Vec::with_capacity(length as usize);
        file.take(self.left + 1).read_to_end(&mut bytes)?;
        let length = bytes.len() as u64;
        self.left = self.left.checked_sub(length).ok_or(Failure::Fault(too_large(length)))?;
        self.hasher.update(&length.to_le_bytes());
        self.hasher.update(&bytes);
        Ok(bytes)
    }
}

enum Failure {
    System(io::Error),
    Fault(MeshFault),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::System(error)
    }
}
