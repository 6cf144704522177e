//! The folder of one scene's or study's results: whose it is, and which of its files an earlier run left.

use super::error::SaveError;
use crate::progress::Progress;
use crate::result::kind::ResultKind;
use crate::result::manifest::{FILE_NAME, LARGEST_FILE, Manifest};
use crate::result::output_folder::{OutputError, OutputFolder};
use crate::result::trajectory::Trajectory;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};
use vantage_dataset::store::{FolderLock, read_regular};
use vantage_formats::npz::Npz;

/// The manifest's place while files are written: what they are of, and which an earlier run left.
const PARTIAL: &str = "manifest.partial.json";

/// What is read of a manifest, or of what stood in its place when a run was killed.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Before {
    of: Option<ResultKind>,
    #[serde(default)]
    files: BTreeSet<String>,
}

impl Before {
    /// That of a folder without a manifest of ours is empty. Of one that does not say what it is of, no file is believed to be ours.
    fn read(folder: &Path) -> Self {
        let text =
            [FILE_NAME, PARTIAL].iter().find_map(|name| read_regular(&folder.join(name), LARGEST_FILE).ok());
        let before: Self = text.and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
        let files = if before.of.is_some() { before.files } else { BTreeSet::new() };
        Self { files, ..before }
    }
}

/// A folder that results are written to. What an earlier run wrote and this one does not is removed at the end; other files are
/// left alone. While files are written it has no manifest.
pub struct ResultFolder {
    folder: OutputFolder,
    of: ResultKind,
    before: Before,
    written: RefCell<BTreeSet<String>>,
    _lock: FolderLock,
}

impl ResultFolder {
    /// Opens the folder of the results of `name` below `out`, once no other run writes into it.
    pub fn open(
        out: &OutputFolder,
        name: &str,
        of: ResultKind,
        progress: &Progress,
    ) -> Result<Self, SaveError> {
        let folder = OutputFolder::probe(&of.place(out.path(), name))?;
        let lock = folder.lock(progress)?;
        let before = Before { of: Some(of), ..Before::read(folder.path()) };
        folder.write(PARTIAL, &serde_json::to_vec_pretty(&before)?)?;
        remove(folder.path(), FILE_NAME);
        Ok(Self { folder, of, before, written: RefCell::default(), _lock: lock })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Writes a file: see [`OutputFolder::write`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        self.written.borrow_mut().insert(name.to_owned());
        self.folder.write(name, bytes)
    }

    /// Writes a trajectory as a TUM file.
    pub fn write_trajectory(&self, name: &str, trajectory: &Trajectory) -> Result<(), SaveError> {
        self.written.borrow_mut().insert(name.to_owned());
        Ok(self.folder.write_trajectory(name, trajectory)?)
    }

    /// Writes an archive of arrays: see [`OutputFolder::write_npz`].
    pub fn write_npz(
        &self,
        name: &str,
        fill: impl FnOnce(&mut Npz) -> io::Result<()>,
    ) -> Result<(), SaveError> {
        self.written.borrow_mut().insert(name.to_owned());
        Ok(self.folder.write_npz(name, fill)?)
    }

    /// Removes what is not of these results, and writes the manifest, which names all files.
    pub fn finish(self, manifest: &Manifest) -> Result<(), SaveError> {
        let written = self.written.into_inner();
        let stale = self.before.files.difference(&written);
        stale.for_each(|name| remove(self.folder.path(), name));
        let manifest =
            Manifest { of: Some(self.of), files: written.into_iter().collect(), ..manifest.clone() };
        self.folder.write(FILE_NAME, manifest.to_json()?.as_bytes())?;
        remove(self.folder.path(), PARTIAL);
        Ok(())
    }
}

/// Removes a file that a manifest names, and its folder where that is empty then. What cannot be removed stays, as does what lies
/// elsewhere by its name or by a link.
fn remove(root: &Path, name: &str) {
    let relative = Path::new(name);
    let plain = !name.is_empty() && relative.components().all(|part| matches!(part, Component::Normal(_)));
    let parent = relative.parent().unwrap_or(Path::new(""));
    let inside =
        |root: PathBuf| fs::canonicalize(root.join(parent)).is_ok_and(|path| path == root.join(parent));
    if !plain || !fs::canonicalize(root).is_ok_and(inside) {
        return;
    }
    let _ = fs::remove_file(root.join(relative));
    if parent != Path::new("") {
        let _ = fs::remove_dir(root.join(parent));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn run(out: &OutputFolder, of: ResultKind, files: &[&str]) -> Result<(), SaveError> {
        let folder = ResultFolder::open(out, "mine", of, &Progress::detect())?;
        files.iter().try_for_each(|name| folder.write(name, b"new"))?;
        folder.finish(&Manifest::new("abc", &[Seed(0)]))
    }

    #[test]
    fn what_an_earlier_run_left_goes_and_what_others_put_there_stays() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        let at = |name: &str| root.path().join("scenes/mine").join(name);
        run(&out, ResultKind::Scene, &["tables.md", "0/truth.tum", "1/truth.tum", "2/truth.tum"]).unwrap();
        for note in ["notes.txt", "2/notes.txt"] {
            fs::write(at(note), "mine").unwrap();
        }
        run(&out, ResultKind::Scene, &["tables.md", "0/truth.tum"]).unwrap();
        for (name, is_there) in [
            ("tables.md", true),
            ("0/truth.tum", true),
            ("1", false),
            ("2/truth.tum", false),
            ("notes.txt", true),
            ("2/notes.txt", true),
        ] {
            assert_eq!(at(name).exists(), is_there, "{name}");
        }
    }

    #[test]
    fn results_of_a_study_and_of_a_scene_of_one_name_lie_apart() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        run(&out, ResultKind::Scene, &["tables.md"]).unwrap();
        run(&out, ResultKind::Study, &["variants.md"]).unwrap();
        for file in ["scenes/mine/tables.md", "studies/mine/variants.md"] {
            assert!(root.path().join(file).exists(), "{file}");
        }
    }

    #[test]
    fn what_a_killed_run_leaves_is_known_and_counts_as_unfinished() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        run(&out, ResultKind::Study, &["old.csv"]).unwrap();
        let killed = ResultFolder::open(&out, "mine", ResultKind::Study, &Progress::detect()).unwrap();
        killed.write("new.csv", b"new").unwrap();
        drop(killed);
        let names = || -> BTreeSet<String> {
            let entries = fs::read_dir(root.path().join("studies/mine")).unwrap();
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
        };
        assert!(!names().contains(FILE_NAME) && names().contains("old.csv"));
        run(&out, ResultKind::Study, &["new.csv"]).unwrap();
        assert!(names().is_superset(&["new.csv".to_owned(), FILE_NAME.to_owned()].into()));
        assert!(!names().contains("old.csv") && !names().contains(PARTIAL));
    }

    #[test]
    fn a_manifest_does_not_lead_out_of_its_folder_nor_is_one_of_others_believed() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        let (outside, folder) = (root.path().join("kept"), root.path().join("scenes/mine"));
        fs::create_dir_all(folder.join("folder")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(root.path(), folder.join("link")).unwrap();
        let names = [
            "../../kept",
            outside.to_str().unwrap(),
            "a/../../../kept",
            ".",
            "",
            "link/kept",
            "folder",
            "old.csv",
        ];
        for (of, stays) in [(serde_json::json!("scene"), false), (serde_json::Value::Null, true)] {
            fs::write(&outside, "kept").unwrap();
            fs::write(folder.join("old.csv"), "old").unwrap();
            let manifest = serde_json::json!({ "of": of, "files": names });
            fs::write(folder.join(FILE_NAME), manifest.to_string()).unwrap();
            run(&out, ResultKind::Scene, &[]).unwrap();
            assert!(outside.exists() && folder.join("folder").exists());
            assert_eq!(folder.join("old.csv").exists(), stays);
        }
    }
}
