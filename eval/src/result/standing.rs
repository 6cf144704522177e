//! The result that lies in a folder already, and what it would lose to another run.

use super::manifest::FILE_NAME;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::Seed;

/// The part of a manifest that tells how full a result is.
#[derive(Debug, Deserialize)]
pub struct Standing {
    seeds: BTreeSet<u64>,
    model_hash: Option<String>,
    #[serde(default)]
    options: Options,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Options {
    train: bool,
}

/// A result that a lesser or another one would take the place of.
#[derive(Debug, Error)]
#[error(
    "{} holds a result of {seeds} seeds, and this run {lacks}: nothing was run; keep that result with --out DIR, or give it up with --replace",
    folder.display()
)]
pub struct FullerResult {
    /// Where it lies.
    pub folder: PathBuf,
    /// How many seeds it has.
    pub seeds: usize,
    /// What the run lacks.
    pub lacks: String,
}

impl Standing {
    /// That in `folder`; `None` where there is no finished result.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_str(&fs::read_to_string(folder.join(FILE_NAME)).ok()?).ok()
    }

    /// Refuses a run without some of the seeds, or with another model than that of the hash; a model that is yet to be trained has none.
    pub fn allows(&self, folder: &Path, seeds: &[Seed], model: Option<&str>) -> Result<(), FullerResult> {
        let missing = self.seeds.iter().filter(|&&seed| !seeds.contains(&Seed(seed))).count();
        let same_model = model.map_or(self.options.train, |hash| self.model_hash.as_deref() == Some(hash));
        let lacks = match (missing, same_model) {
            (0, true) => return Ok(()),
            (0, false) => "is of another model".to_owned(),
            (missing, true) => format!("lacks {missing} of them"),
            (missing, false) => format!("is of another model and lacks {missing} of them"),
        };
        Err(FullerResult { folder: folder.to_owned(), seeds: self.seeds.len(), lacks })
    }
}

#[cfg(test)]
mod tests {
    use super::super::manifest::Manifest;
    use super::*;

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
        let told = |seeds: &[Seed], model| {
            let allowed = Standing::read(folder.path()).unwrap().allows(folder.path(), seeds, model);
            allowed.err().map(|error| error.to_string()).unwrap_or_default()
        };
        let three = [0, 1, 2].map(Seed);
        assert_eq!([told(&three, Some("def")), told(&three[..2], Some("def"))], ["", ""]);
        assert!(told(&three[1..], Some("def")).contains("of 2 seeds, and this run lacks 1 of them"));
        assert!(told(&three, Some("other")).contains("another model") && told(&three, None).contains("--replace"));
        assert!(told(&three[..1], None).contains("another model and lacks 1"));
        manifest.options = serde_json::json!({ "train": true });
        write(&manifest);
        assert_eq!(told(&three, None), "");
    }
}
