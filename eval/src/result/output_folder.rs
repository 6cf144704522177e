//! The output folder: found writable before any work, and written file by file so that none is ever half there.

use crate::exit::{Ends, Exit};
use crate::progress::Progress;
use crate::result::made_folders::MadeFolders;
use crate::result::trajectory::Trajectory;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::store::{FolderLock, StoreError, rename_durably, write_atomically, write_tum};
use vantage_formats::npz::Npz;

/// File by which a folder is found writable.
const PROBE: &str = ".probe.tmp";

/// A folder that was found writable. Where it was made for that, and nothing is written into it, it goes again.
#[derive(Debug)]
pub struct OutputFolder(PathBuf, #[expect(dead_code, reason = "held for its drop")] MadeFolders);

/// Why nothing can be written.
#[derive(Debug, Error)]
#[error("cannot write {}: {source}; choose another folder with --out, or make room", path.display())]
pub struct OutputError {
    /// The file or folder.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

impl Ends for OutputError {
    fn exit(&self) -> Exit {
        Exit::CannotWrite
    }
}

impl OutputFolder {
    /// Makes the folder where it is missing, and writes and removes a file in it.
    pub fn probe(path: &Path) -> Result<Self, OutputError> {
        let removed = |probe: &Path| match fs::remove_file(probe) {
            // Another run may have been as far.
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            removed => removed,
        };
        // One name for all, so that what a killed run leaves is removed by the next one.
        let probe = path.join(PROBE);
        let made = MadeFolders::make(path).and_then(|made| {
            fs::write(&probe, b"probe")?;
            removed(&probe)?;
            Ok(made)
        });
        let made = made.map_err(|source| OutputError { path: path.to_owned(), source })?;
        Ok(Self(path.to_owned(), made))
    }

    /// The right to write into it, which another run gives up first if it has it.
    pub fn lock(&self, progress: &Progress) -> Result<FolderLock, StoreError> {
        FolderLock::take(&self.0, &|waiting| progress.note(&waiting.to_string()))
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> Result<bool, OutputError> {
        let entries = fs::read_dir(&self.0).map_err(|source| OutputError { path: self.0.clone(), source })?;
        Ok(entries.flatten().all(|entry| FolderLock::is_named(&entry.file_name())))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file, its folders included: see [`write_atomically`].
    pub fn write(&self, relative: impl AsRef<Path>, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.0.join(relative);
        make_parent(&path)
            .and_then(|()| write_atomically(&path, bytes))
            .map_err(|source| OutputError { path, source })
    }

    /// Writes a trajectory as a TUM file, in the same way.
    pub fn write_trajectory(
        &self,
        relative: impl AsRef<Path>,
        trajectory: &Trajectory,
    ) -> Result<(), StoreError> {
        self.write_with(relative, |path| {
            write_tum(path, trajectory.timestamps(), trajectory.world_from_robot()).map(drop)
        })
    }

    /// Has an archive of arrays written, in the same way.
    pub fn write_npz(
        &self,
        relative: impl AsRef<Path>,
        fill: impl FnOnce(&mut Npz) -> io::Result<()>,
    ) -> Result<(), StoreError> {
        let told = self.0.join(relative.as_ref());
        self.write_with(relative, |path| {
            let written = Npz::create(path).and_then(|mut npz| {
                fill(&mut npz)?;
                npz.finish()
            });
            written.map_err(|source| StoreError::Write { path: told, source })
        })
    }

    /// Has a file written under a temporary name, then renames it; where that fails nothing is left.
    pub fn write_with(
        &self,
        relative: impl AsRef<Path>,
        fill: impl FnOnce(&Path) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let path = self.0.join(relative);
        let mut temporary = path.clone().into_os_string();
        temporary.push(".tmp");
        let temporary = PathBuf::from(temporary);
        let refuse = |source| StoreError::Write { path: path.clone(), source };
        make_parent(&path).map_err(refuse)?;
        let written = fill(&temporary).and_then(|()| rename_durably(&temporary, &path).map_err(refuse));
        if written.is_err() {
            // It may not be there.
            let _ = fs::remove_file(&temporary);
        }
        written
    }
}

fn make_parent(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Pose;

    #[test]
    fn files_are_written_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(&folder.path().join("a/b")).unwrap();
        out.write("scene/0/truth.tum", b"old").unwrap();
        let track = Trajectory::new(vec![0.0, 0.1], vec![Pose::translation(1.0, 2.0, 3.0); 2]).unwrap();
        out.write_trajectory("scene/0/truth.tum", &track).unwrap();
        let text = fs::read_to_string(out.path().join("scene/0/truth.tum")).unwrap();
        assert_eq!(Trajectory::from_tum(&text).unwrap(), track);
        let names = |path: PathBuf| -> Vec<_> {
            fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name()).collect()
        };
        fs::write(out.path().join(PROBE), "of a killed run").unwrap();
        OutputFolder::probe(out.path()).unwrap();
        assert_eq!(names(out.path().to_owned()), ["scene"]);
        assert_eq!(names(out.path().join("scene/0")), ["truth.tum"]);
    }

    #[test]
    fn a_folder_below_a_file_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = OutputFolder::probe(&file.join("out")).unwrap_err().to_string();
        assert!(error.contains("file/out") && error.contains("--out"), "{error}");
    }

    #[test]
    fn an_archive_that_fails_leaves_nothing_and_is_told_by_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(folder.path()).unwrap();
        let before = fs::read_dir(folder.path()).unwrap().count();
        let written = out.write_npz("a/x.npz", |npz| {
            npz.file("part", b"some")?;
            Err(io::Error::other("the disk is full"))
        });
        let told = written.unwrap_err().to_string();
        assert!(told.contains("x.npz") && !told.contains("npz.tmp"), "{told}");
        assert_eq!(fs::read_dir(folder.path().join("a")).unwrap().count(), 0);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), before + 1);
    }
}
