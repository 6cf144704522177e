//! Files written whole or not at all, and read only where they are files.

use std::fs::{self, File, FileType};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// Puts `bytes` at `path` whole or not at all: `<path>.tmp`, fsync, rename, fsync of the folder.
///
/// After a kill or an error what was at `path` is there still. A kill may leave `<path>.tmp`, which the next call replaces.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".tmp");
    let temporary = PathBuf::from(temporary);
    let written = write_synced(&temporary, bytes).and_then(|()| rename_durably(&temporary, path));
    if written.is_err() {
        // The first error is the one to tell.
        let _ = fs::remove_file(&temporary);
    }
    written
}

/// Gives a file, whose bytes are on disk, the name `to` in place of what has it: rename, fsync of the folder.
pub fn rename_durably(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)?;
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty());
    sync(folder.unwrap_or(Path::new(".")))
}

/// Makes the names in a folder outlive a power cut.
pub(super) fn sync(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

fn write_synced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// What a message calls a thing of a kind.
pub fn file_kind(kind: FileType) -> &'static str {
    if kind.is_file() {
        "a regular file"
    } else if kind.is_dir() {
        "a folder"
    } else if kind.is_symlink() {
        "a link"
    } else {
        "a pipe, a socket or a device"
    }
}

/// Opens a regular file, or a link to one.
///
/// # Errors
/// [`ErrorKind::InvalidInput`] for a folder, pipe, socket or device, which are not opened: a pipe could be waited for without end.
pub fn open_regular(path: &Path) -> io::Result<File> {
    let require = |metadata: fs::Metadata| {
        let refusal = || io::Error::new(ErrorKind::InvalidInput, "it is not a regular file");
        metadata.is_file().then_some(()).ok_or_else(refusal)
    };
    require(fs::metadata(path)?)?;
    let file = File::open(path)?;
    require(file.metadata()?)?;
    Ok(file)
}

/// The bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// Those of [`open_regular`], and [`ErrorKind::FileTooLarge`] where there are more than `limit` bytes.
pub fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_regular(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::new(ErrorKind::FileTooLarge, format!("it has more than {limit} bytes")));
    }
    Ok(bytes)
}
