//! Files that are hashed while they are written and read.

use super::error::{Fault, StoreError};
use super::file_record::FileRecord;
use super::whole_file::{self, file_kind, open_regular, read_regular, write_atomically};
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Component, Path, PathBuf};

const BUFFER: usize = 1 << 16;

/// A stream that hashes and counts the bytes that pass.
pub(super) struct Hashing<F> {
    inner: F,
    hasher: blake3::Hasher,
    bytes: u64,
}

impl<F> Hashing<F> {
    fn new(inner: F) -> Self {
        Self { inner, hasher: blake3::Hasher::new(), bytes: 0 }
    }

    fn pass(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
        self.bytes += bytes.len() as u64;
    }

    fn record(&self) -> FileRecord {
        FileRecord { bytes: self.bytes, blake3: self.hasher.finalize().to_hex().to_string() }
    }
}

impl<F: Write> Write for Hashing<F> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(buffer)?;
        self.pass(&buffer[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<F: Read> Read for Hashing<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.pass(&buffer[..read]);
        Ok(read)
    }
}

/// Where a file's bytes go.
pub(super) type Sink = BufWriter<Hashing<File>>;
/// Where a file's bytes come from.
pub(super) type Source = BufReader<Hashing<File>>;

/// Writes `path` with `fill`, to disk and not just to the system's buffers.
pub(super) fn write_hashed(
    path: &Path,
    fill: impl FnOnce(&mut Sink) -> io::Result<()>,
) -> Result<FileRecord, StoreError> {
    let write = || {
        let mut sink = BufWriter::with_capacity(BUFFER, Hashing::new(File::create(path)?));
        fill(&mut sink)?;
        let hashing = sink.into_inner().map_err(io::IntoInnerError::into_error)?;
        hashing.inner.sync_all()?;
        Ok(hashing.record())
    };
    write().map_err(StoreError::write(path))
}

/// Parses `folder/name` in one pass and proves that the bytes parsed are those of `record`.
///
/// Damage is told before what the parser makes of the damaged bytes.
pub(super) fn read_verified<T>(
    folder: &Path,
    name: &str,
    record: &FileRecord,
    parse: impl FnOnce(&mut Source) -> Result<T, StoreError>,
) -> Result<T, StoreError> {
    let path = regular_file(folder, name)?;
    let damaged = |got: String, expected: String| StoreError::Damaged { path: path.clone(), got, expected };
    let file = open_regular(&path).map_err(StoreError::read(&path))?;
    let bytes = file.metadata().map_err(StoreError::read(&path))?.len();
    if bytes != record.bytes {
        return Err(damaged(format!("{bytes} bytes"), format!("{} bytes", record.bytes)));
    }
    let mut source = BufReader::with_capacity(BUFFER, Hashing::new(file));
    let parsed = parse(&mut source);
    io::copy(&mut source, &mut io::sink()).map_err(StoreError::read(&path))?;
    let found = source.get_ref().record();
    if found != *record {
        return Err(damaged(format!("blake3 {}", found.blake3), format!("blake3 {}", record.blake3)));
    }
    parsed
}

/// Proves the size and hash of each file, by its path in the folder with `/`.
pub fn verify_files<'a>(
    folder: &Path,
    files: impl IntoIterator<Item = (&'a String, &'a FileRecord)>,
) -> Result<(), StoreError> {
    files.into_iter().try_for_each(|(name, record)| read_verified(folder, name, record, |_| Ok(())))
}

/// Hashes a file that somebody else wrote, and sees it to disk.
pub fn hash_and_sync(path: &Path) -> Result<FileRecord, StoreError> {
    let mut source = Hashing::new(open_regular(path).map_err(StoreError::read(path))?);
    let mut buffer = vec![0; BUFFER];
    while source.read(&mut buffer).map_err(StoreError::read(path))? > 0 {}
    source.inner.sync_all().map_err(StoreError::write(path))?;
    Ok(source.record())
}

/// The path of `name` in `folder`: a regular file that no link or `..` leads out of it.
fn regular_file(folder: &Path, name: &str) -> Result<PathBuf, StoreError> {
    inside(name).map_err(StoreError::invalid(folder))?;
    let mut path = folder.to_owned();
    let parts: Vec<_> = Path::new(name).components().collect();
    for (i, part) in parts.iter().enumerate() {
        path.push(part);
        let kind = match fs::symlink_metadata(&path) {
            Ok(metadata) => metadata.file_type(),
            Err(source) if source.kind() == ErrorKind::NotFound => {
                let (got, expected) = ("no file".to_owned(), "a file".to_owned());
                return Err(StoreError::Damaged { path: folder.join(name), got, expected });
            }
            Err(source) => return Err(StoreError::Read { path, source }),
        };
        let (right, expected) = if i + 1 == parts.len() {
            (kind.is_file(), "a regular file, not a link")
        } else {
            (kind.is_dir(), "a folder, not a link")
        };
        if !right {
            let place: PathBuf = parts[..=i].iter().collect();
            let fault = Fault::new(&place.to_string_lossy(), None, "type", file_kind(kind), expected);
            return Err(StoreError::invalid(folder)(fault));
        }
    }
    Ok(path)
}

/// Refuses a file name that could lead out of its folder.
pub fn inside(name: &str) -> Result<(), Fault> {
    let plain = !name.is_empty()
        && !name.contains(['\\', ':', '\0', char::REPLACEMENT_CHARACTER])
        && name.split('/').all(|part| !part.is_empty())
        && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    let fault = || Fault::new(name, None, "name", format!("{name:?}"), "a plain path inside the folder");
    plain.then_some(()).ok_or_else(fault)
}

/// [`write_atomically`], with the path told where it fails.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    write_atomically(path, bytes).map_err(StoreError::write(path))
}

/// Makes the names in a folder outlive a power cut.
pub fn sync_folder(folder: &Path) -> Result<(), StoreError> {
    whole_file::sync(folder).map_err(StoreError::write(folder))
}

/// Makes a folder and its parents.
pub fn make_folder(folder: &Path) -> Result<(), StoreError> {
    fs::create_dir_all(folder).map_err(StoreError::write(folder))
}

/// Removes a file if it is there.
pub fn remove_if_there(path: &Path) -> Result<(), StoreError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(StoreError::write(path)(source)),
        _ => Ok(()),
    }
}

/// Reads a file of at most `limit` bytes whole.
pub(super) fn read_small(path: &Path, limit: u64) -> Result<Vec<u8>, StoreError> {
    read_regular(path, limit).map_err(|source| match source.kind() {
        ErrorKind::FileTooLarge => {
            let (got, expected) = (format!("over {limit} bytes"), format!("at most {limit} bytes"));
            StoreError::Damaged { path: path.to_owned(), got, expected }
        }
        _ => StoreError::read(path)(source),
    })
}
