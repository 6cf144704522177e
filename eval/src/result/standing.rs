//! The result that lies in a folder already, its tables, and what it would lose to another run.

use super::manifest::{FILE_NAME, LARGEST_FILE};
use super::report;
use super::results_file::Results;
use super::table::Table;
use crate::exit::Ends;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::Seed;
use vantage_dataset::store::read_regular;

/// The part of a manifest that tells how full a result is, and what stands above its tables.
#[derive(Debug, Deserialize)]
pub struct Standing {
    scene_hash: String,
    seeds: BTreeSet<u64>,
    model_hash: Option<String>,
    caveat: Option<String>,
    #[serde(default)]
    model_hashes: BTreeMap<String, String>,
    options: Option<Options>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Options {
    train: bool,
    /// Folders; null, or a single one, of older results.
    model: serde_json::Value,
}

/// A result that a lesser or another one would take the place of.
#[derive(Debug, Error)]
#[error(
    "{} holds a result of {holds}, and this run {lacks}: nothing was run; keep that result with --out DIR, or give it up with --replace",
    folder.display()
)]
pub struct FullerResult {
    /// Where it lies.
    pub folder: PathBuf,
    /// What it is of, such as a number of seeds.
    pub holds: String,
    /// What the run lacks.
    pub lacks: String,
}

impl Ends for FullerResult {}

impl Standing {
    /// That in `folder`; `None` where there is no finished result.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&read_regular(&folder.join(FILE_NAME), LARGEST_FILE).ok()?).ok()
    }

    /// Its tables, of its scores as they were read: see [`report::markdown`].
    pub fn markdown(&self, results: &Results) -> String {
        report::markdown(results, self.model_hash.as_deref(), self.caveat.as_deref())
    }

    /// Whether it is of the scene of this hash.
    pub fn is_of_scene(&self, hash: &str) -> bool {
        self.scene_hash == hash
    }

    /// Whether it is of no other models than those of these hashes.
    pub fn is_of(&self, models: &[String]) -> bool {
        self.model_hash.iter().chain(self.model_hashes.values()).all(|model| models.contains(model))
    }

    /// Whether it is of a model that was trained for it, of a scene that comes `with_a_model` or without one.
    pub fn is_of_training(&self, with_a_model: bool) -> bool {
        let untold = Options::default();
        let options = self.options.as_ref().unwrap_or(&untold);
        options.train || (options.model.is_null() && !with_a_model)
    }

    /// Refuses a run without some of the seeds, or with another model.
    pub fn allows(&self, folder: &Path, seeds: &[Seed], same_model: bool) -> Result<(), FullerResult> {
        let missing = self.seeds.iter().filter(|&&seed| !seeds.contains(&Seed(seed))).count();
        let lacks = match (missing, same_model) {
            (0, true) => return Ok(()),
            (0, false) => "is of another model".to_owned(),
            (missing, true) => format!("lacks {missing} of them"),
            (missing, false) => format!("is of another model and lacks {missing} of them"),
        };
        Err(FullerResult { folder: folder.to_owned(), holds: format!("{} seeds", self.seeds.len()), lacks })
    }

    /// Refuses a run without some of the tables that are in `folder`.
    pub fn allows_tables(folder: &Path, tables: &BTreeSet<&str>) -> Result<(), FullerResult> {
        let Ok(results) = Results::read(folder) else { return Ok(()) };
        let missing: Vec<&str> =
            results.tables.iter().map(Table::name).filter(|name| !tables.contains(name)).collect();
        let Some(first) = missing.first() else { return Ok(()) };
        let holds = format!("{} cells", results.tables.len());
        let lacks = format!("lacks {} of them, the first {first:?}", missing.len());
        Err(FullerResult { folder: folder.to_owned(), holds, lacks })
    }
}

#[cfg(test)]
mod tests {
    use super::super::manifest::Manifest;
    use super::*;
    use std::fs;

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_no_manifest() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join(FILE_NAME);
        assert!(std::process::Command::new("mkfifo").arg(pipe).status().unwrap().success());
        assert!(Standing::read(folder.path()).is_none());
    }

    #[test]
    fn fewer_seeds_and_another_model_are_refused_and_more_seeds_are_not() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Standing::read(folder.path()).is_none());
        let write = |manifest: &Manifest| {
            fs::write(folder.path().join(FILE_NAME), manifest.to_json().unwrap()).unwrap();
        };
        let mut manifest = Manifest::new("abc", &[Seed(0), Seed(1)]);
        manifest.model_hash = Some("def".into());
        write(&manifest);
        let read = || Standing::read(folder.path()).unwrap();
        assert!(read().is_of_scene("abc") && !read().is_of_scene("abd"));
        let told = |seeds: &[Seed], same_model| {
            let allowed = read().allows(folder.path(), seeds, same_model);
            allowed.err().map(|error| error.to_string()).unwrap_or_default()
        };
        let three = [0, 1, 2].map(Seed);
        assert_eq!([told(&three, true), told(&three[..2], true)], ["", ""]);
        assert!(told(&three[1..], true).contains("of 2 seeds, and this run lacks 1 of them"));
        assert!(told(&three, false).contains("another model") && told(&three, false).contains("--replace"));
        assert!(told(&three[..1], false).contains("another model and lacks 1"));
        let of =
            |models: &[&str]| read().is_of(&models.iter().map(|&model| model.to_owned()).collect::<Vec<_>>());
        assert!(of(&["def"]) && of(&["other", "def"]) && !of(&["other"]));
        assert!(read().is_of_training(false) && !read().is_of_training(true));
        manifest.options = serde_json::json!({ "train": true, "model": null });
        write(&manifest);
        assert!(read().is_of_training(true));
        manifest.options = serde_json::json!({ "train": false, "model": ["mine"] });
        write(&manifest);
        assert!(!read().is_of_training(false));
    }
}
