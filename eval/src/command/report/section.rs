//! One result of a report: its scores, its origin and its pictures.

use super::error::ReportError;
use super::pictures::{Picture, pictures};
use crate::command::error::BenchError;
use crate::result::manifest::{FILE_NAME, LARGEST_FILE};
use crate::result::report::markdown;
use crate::result::results_file::Results;
use crate::result::summary_text::answers;
use crate::score::trajectory_scores::TRAJECTORIES;
use serde_json::Value;
use std::path::Path;
use vantage_dataset::store::read_regular;

/// A finished result.
pub(super) struct Section {
    pub(super) results: Results,
    pub(super) manifest: Value,
    pub(super) pictures: Vec<Picture>,
}

impl Section {
    pub(super) fn read(folder: &Path) -> Result<Self, BenchError> {
        let results = Results::read(folder)?;
        let path = folder.join(FILE_NAME);
        let failed = |reason: String| ReportError::Manifest { path: path.clone(), reason };
        let bytes = read_regular(&path, LARGEST_FILE).map_err(|error| failed(error.to_string()))?;
        let manifest: Value = serde_json::from_slice(&bytes).map_err(|error| failed(error.to_string()))?;
        let files = match manifest.get("files") {
            Some(files) => {
                serde_json::from_value(files.clone()).map_err(|error| failed(error.to_string()))?
            }
            // Older manifests name none.
            None => all_in(folder),
        };
        Self::new(folder, results, manifest, &files)
    }

    /// With the pictures among its files, and no others that may lie in the folder.
    pub(super) fn new(
        folder: &Path,
        results: Results,
        manifest: Value,
        files: &[String],
    ) -> Result<Self, BenchError> {
        Ok(Self { results, manifest, pictures: pictures(folder, files)? })
    }

    /// What rows with a model do to the trajectory, and what a reader has to know first.
    pub(super) fn said(&self) -> Vec<String> {
        let answers = self.results.table(TRAJECTORIES).map(answers).unwrap_or_default();
        self.text("caveat").map(str::to_owned).into_iter().chain(answers).collect()
    }

    pub(super) fn markdown(&self) -> String {
        markdown(&self.results, self.text("model_hash"), self.text("caveat"))
    }

    /// Name and value of what the result was made from and on.
    pub(super) fn origin(&self) -> Vec<(String, String)> {
        let shown = [
            "version",
            "commit",
            "scene_hash",
            "dataset_hash",
            "model_hash",
            "model_hashes",
            "renderer",
            "host",
            "command",
            "seconds",
        ];
        let value = |name: &str| self.manifest.get(name).filter(|value| !value.is_null());
        shown.iter().filter_map(|name| Some((name.replace('_', " "), plain(value(name)?)))).collect()
    }

    fn text(&self, name: &str) -> Option<&str> {
        self.manifest.get(name)?.as_str()
    }
}

fn all_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

/// A value as people read it.
fn plain(value: &Value) -> String {
    let joined = |parts: Vec<String>, by: &str| parts.join(by);
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) if values.iter().all(Value::is_string) => {
            joined(values.iter().map(plain).collect(), " ")
        }
        Value::Array(values) => joined(values.iter().map(plain).collect(), "; "),
        Value::Object(fields) => joined(
            fields
                .iter()
                .filter(|(_, value)| !value.is_null())
                .map(|(name, value)| format!("{name} {}", plain(value)))
                .collect(),
            ", ",
        ),
        Value::Number(number) => number
            .as_f64()
            .filter(|_| number.is_f64())
            .map_or(number.to_string(), |value| format!("{value:.1}")),
        other => other.to_string(),
    }
}
