//! The folder of one scene's or study's results: whose it is, and which of its files an earlier run left.

use crate::error::BenchError;
use crate::manifest::{FILE_NAME, Manifest};
use crate::output::{OutputError, OutputFolder};
use crate::progress::Progress;
use crate::trajectory::Trajectory;
use serde::Deserialize;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::{Component, Path, PathBuf};
use vantage_dataset::store::FolderLock;

/// What results are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// A scene.
    Scene,
    /// A study.
    Study,
}

impl fmt::Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scene => "scene",
            Self::Study => "study",
        })
    }
}

/// What is read of the manifest that an earlier run left.
#[derive(Debug, Default, Deserialize)]
struct Before {
    #[serde(default)]
    command: Vec<String>,
    #[serde(default)]
    files: BTreeSet<String>,
}

impl Before {
    /// That of a folder without a manifest of ours is empty.
    fn read(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join(FILE_NAME)).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    fn of(&self) -> Option<Of> {
        let command = self.command.get(1)?;
        Some(if command == "study" { Of::Study } else { Of::Scene })
    }
}

/// A folder that results are written to. What an earlier run wrote and this one does not is removed at the end; other files are
/// left alone.
pub struct ResultFolder {
    folder: OutputFolder,
    before: Before,
    written: RefCell<BTreeSet<String>>,
    _lock: FolderLock,
}

impl ResultFolder {
    /// Refuses the place below `out` where results of something else lie that has the same name.
    pub fn check(out: &OutputFolder, name: &str, of: Of) -> Result<(), BenchError> {
        let folder = out.path().join(name);
        match Before::read(&folder).of() {
            Some(other) if other != of => Err(BenchError::OtherResults { folder, of: other }),
            _ => Ok(()),
        }
    }

    /// Opens the folder of the results of `name` below `out`, once no other run writes into it.
    pub fn open(out: &OutputFolder, name: &str, of: Of, progress: &Progress) -> Result<Self, BenchError> {
        Self::check(out, name, of)?;
        let folder = OutputFolder::probe(&out.path().join(name))?;
        let lock = folder.lock(progress)?;
        let before = Before::read(folder.path());
        Ok(Self { folder, before, written: RefCell::default(), _lock: lock })
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
    pub fn write_trajectory(&self, name: &str, trajectory: &Trajectory) -> Result<(), BenchError> {
        self.written.borrow_mut().insert(name.to_owned());
        Ok(self.folder.write_trajectory(name, trajectory)?)
    }

    /// Removes what is not of these results, and writes the manifest, which names all files.
    pub fn finish(self, manifest: &Manifest) -> Result<(), BenchError> {
        let written = self.written.into_inner();
        for name in self.before.files.difference(&written) {
            remove(self.folder.path(), name)?;
        }
        let manifest = Manifest { files: written.into_iter().collect(), ..manifest.clone() };
        Ok(self.folder.write(FILE_NAME, manifest.to_json()?.as_bytes())?)
    }
}

/// Removes a file that a manifest names, and its folder where that is empty then.
fn remove(root: &Path, name: &str) -> Result<(), OutputError> {
    if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
        return Ok(());
    }
    let path: PathBuf = root.join(name);
    match fs::remove_file(&path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            return Err(OutputError { path, source });
        }
        _ => {}
    }
    if let Some(parent) = path.parent().filter(|parent| *parent != root) {
        // It stays where something else is in it.
        let _ = fs::remove_dir(parent);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn run(out: &OutputFolder, of: Of, files: &[&str]) -> Result<(), BenchError> {
        let folder = ResultFolder::open(out, "mine", of, &Progress::detect())?;
        files.iter().try_for_each(|name| folder.write(name, b"new"))?;
        let word = if of == Of::Study { "study" } else { "mine.yaml" };
        let command = vec!["bench".to_owned(), word.to_owned()];
        folder.finish(&Manifest { command, ..Manifest::new("abc", &[Seed(0)]) })
    }

    #[test]
    fn what_an_earlier_run_left_goes_and_what_others_put_there_stays() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        let at = |name: &str| root.path().join("mine").join(name);
        run(&out, Of::Scene, &["tables.md", "0/truth.tum", "1/truth.tum", "2/truth.tum"]).unwrap();
        for note in ["notes.txt", "2/notes.txt"] {
            fs::write(at(note), "mine").unwrap();
        }
        run(&out, Of::Scene, &["tables.md", "0/truth.tum"]).unwrap();
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
    fn results_of_a_study_and_of_a_scene_do_not_mix() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        for (first, second, name) in [(Of::Scene, Of::Study, "scene"), (Of::Study, Of::Scene, "study")] {
            run(&out, first, &["tables.md"]).unwrap();
            let error = run(&out, second, &["tables.md"]).unwrap_err().to_string();
            assert!(error.contains(&format!("results of a {name} ")) && error.contains("mine"), "{error}");
            fs::remove_dir_all(root.path().join("mine")).unwrap();
        }
    }

    #[test]
    fn a_manifest_does_not_lead_out_of_its_folder() {
        let root = tempfile::tempdir().unwrap();
        let out = OutputFolder::probe(root.path()).unwrap();
        fs::create_dir(root.path().join("mine")).unwrap();
        fs::write(root.path().join("kept"), "kept").unwrap();
        let absolute = root.path().join("kept");
        let manifest = serde_json::json!({ "files": ["../kept", absolute, "a/../../kept", "."] });
        fs::write(root.path().join("mine/manifest.json"), manifest.to_string()).unwrap();
        run(&out, Of::Scene, &[]).unwrap();
        assert!(absolute.exists());
    }
}
