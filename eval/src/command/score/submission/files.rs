//! What a submission's folder holds.

use crate::command::error::BenchError;
use crate::command::score::error::ScoreError;
use crate::command::task::error::TaskError;
use crate::command::task::sealed::Sealed;
use crate::progress::Progress;
use crate::scene_file::row_name::reserved_names;
use crate::score::association_entry::AssociationEntry;
use crate::score::entry::Entry;
use crate::score::object_map::Proposal;
use crate::score::object_map_file::ObjectMap;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use vantage_dataset::Seed;
use vantage_dataset::store::read_regular;

/// What a submission says of itself.
const ABOUT: &str = "submission.yaml";
/// The folders that are scored.
const PARTS: [&str; 3] = ["trajectories", "associations", "maps"];
/// Largest such file, bytes.
const LARGEST_FILE: u64 = 1 << 20;

/// `submission.yaml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct About {
    /// The name of its rows.
    pub name: String,
    /// What it keeps to.
    pub division: Division,
    /// The hash of the truth that its task was published with.
    pub task: String,
    /// What it is, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
}

/// The rules that a submission keeps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Division {
    /// Crops are read by the scene's reference model alone.
    Closed,
    /// By anything.
    Open,
}

/// The answers.
pub struct Submission {
    pub about: About,
    pub trajectories: Option<Entry>,
    pub associations: Option<AssociationEntry>,
    /// By episode; empty where there is no folder of maps.
    pub maps: Vec<Option<ObjectMap>>,
}

impl Submission {
    /// Reads the answers to the task whose truth has this hash. Tells of what is not scored.
    pub fn read(folder: &Path, sealed: &Sealed, hash: &str) -> Result<Self, BenchError> {
        let about = About::read(folder)?;
        if about.task != hash {
            let reason = format!("task: {} is answered, and this is the truth of {hash}", about.task);
            return Err(wrong(&folder.join(ABOUT), &reason).into());
        }
        let numbers = sealed.numbers();
        without_links(folder, &numbers, &Progress::detect())?;
        let part = |name: &str| Some(folder.join(name)).filter(|path| path.exists());
        let mut trajectories = None;
        if let Some(path) = part("trajectories") {
            let opened = Entry::open(&[path], &[], &numbers, &Progress::detect());
            trajectories = opened.map_err(|error| wrong(&error.path, &error.reason))?.pop();
        }
        let mut associations = None;
        if let Some(path) = part("associations") {
            let opened = AssociationEntry::open(&[path], &[], &numbers);
            associations = opened.map_err(|error| wrong(&error.path, &error.reason))?.pop();
        }
        let mut maps = Vec::new();
        if let Some(path) = part("maps") {
            let read = |number: &Seed| Ok(ObjectMap::read(&path.join(format!("{}.csv", number.0)))?);
            maps = numbers.iter().map(read).collect::<Result<_, ScoreError>>()?;
            if maps.iter().all(Option::is_none) {
                return Err(wrong(&path, "no map; expected 0.csv and so on").into());
            }
        }
        if trajectories.is_none() && associations.is_none() && maps.is_empty() {
            let told = "nothing to score; expected a folder `trajectories`, `associations` or `maps`";
            return Err(wrong(folder, told).into());
        }
        Ok(Self { about, trajectories, associations, maps })
    }

    /// The objects of all maps.
    pub fn proposals(&self) -> impl Iterator<Item = &Proposal> + Clone {
        self.maps.iter().flatten().flat_map(|map| &map.proposals)
    }
}

impl About {
    fn read(folder: &Path) -> Result<Self, TaskError> {
        let path = folder.join(ABOUT);
        let bytes = match read_regular(&path, LARGEST_FILE) {
            Ok(bytes) => bytes,
            Err(source) => return Err(TaskError::Read { path, source }),
        };
        let about: Self =
            serde_saphyr::from_slice(&bytes).map_err(|error| wrong(&path, &error.to_string()))?;
        let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
        let begins = about.name.starts_with(char::is_alphanumeric);
        if !begins || about.name.len() > 100 || !about.name.chars().all(is_plain) {
            let told = "name: expected letters, digits, '-', '_' and '.' alone, a letter or digit first";
            return Err(wrong(&path, told));
        }
        if reserved_names().contains(&about.name) {
            return Err(wrong(&path, "name: a row of ours has it; choose another"));
        }
        Ok(about)
    }
}

/// Refuses links, which may lead to the truth, and tells of what is not scored.
fn without_links(folder: &Path, episodes: &[Seed], progress: &Progress) -> Result<(), TaskError> {
    let entries = |folder: &Path| -> Result<Vec<PathBuf>, TaskError> {
        let read = std::fs::read_dir(folder);
        let read = read.map_err(|source| TaskError::Read { path: folder.to_owned(), source })?;
        Ok(read.filter_map(|entry| Some(entry.ok()?.path())).collect())
    };
    let is_link = |path: &Path| path.symlink_metadata().is_ok_and(|found| found.is_symlink());
    for path in entries(folder)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_part = PARTS.contains(&&*name);
        let below = if is_part && path.is_dir() && !is_link(&path) { entries(&path)? } else { Vec::new() };
        if let Some(link) = below.iter().chain([&path]).find(|path| is_link(path)) {
            return Err(wrong(link, "it is a link; put the file itself there"));
        }
        if !is_part && name != ABOUT {
            progress.note(&format!("note: {} is not scored", path.display()));
        }
        // Of trajectories, their reader tells.
        let is_episode = |name: &str| episodes.iter().any(|number| name == format!("{}.csv", number.0));
        let names = below.iter().filter_map(|path| path.file_name()).map(|name| name.to_string_lossy());
        let mut others: Vec<_> = names.filter(|other| name != PARTS[0] && !is_episode(other)).collect();
        others.sort();
        if let Some(first) = others.first() {
            progress.note(&format!(
                "note: {} files in {} are of no episode and not scored, {first} first",
                others.len(),
                path.display()
            ));
        }
    }
    Ok(())
}

fn wrong(path: &Path, reason: &str) -> TaskError {
    TaskError::Submission { path: path.to_owned(), reason: reason.to_owned() }
}
