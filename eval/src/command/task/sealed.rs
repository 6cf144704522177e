//! A task as it is published, and its sealed truth.

use super::error::TaskError;
use crate::command::cli::AssociationChoice;
use crate::pipeline::Told;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use vantage_dataset::store::read_regular;
use vantage_dataset::{Detection, Observations, Seed};

/// Version of both files' format.
pub const FORMAT: u32 = 1;
/// The file that is published.
pub const TASK: &str = "task.json";
/// The file that is kept back.
pub const SEALED: &str = "sealed.json";
/// Largest file, bytes.
const LARGEST_FILE: u64 = 256 << 20;

/// What is published of a task beside its episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// [`FORMAT`].
    pub format: u32,
    /// The scene's name.
    pub scene: String,
    /// What is told of who is who.
    pub association: AssociationChoice,
    /// Episodes, in folders `0`, `1` and so on.
    pub episodes: u64,
    /// BLAKE3 of [`SEALED`], hexadecimal: the truth was there when the task was published.
    pub truth: String,
}

/// What is kept back beside the whole episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sealed {
    /// [`FORMAT`].
    pub format: u32,
    /// The scene's name.
    pub scene: String,
    /// Hash of the scene as read.
    pub scene_hash: String,
    /// What is told of who is who.
    pub association: AssociationChoice,
    /// What seeds were drawn from.
    pub secret: String,
    /// The episodes.
    pub episodes: Vec<SealedEpisode>,
}

/// One episode's truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SealedEpisode {
    /// The seed that made it.
    pub seed: Seed,
    /// Hash of the whole episode.
    pub seal: String,
    /// Of each published detection, its number among those of the whole episode.
    pub order: Vec<usize>,
}

impl Sealed {
    /// Reads the truth in a folder, and its hash.
    pub fn read(folder: &Path) -> Result<(Self, String), TaskError> {
        let (sealed, bytes): (Self, _) = read(folder.join(SEALED))?;
        if sealed.format != FORMAT {
            return Err(TaskError::Format { path: folder.join(SEALED), found: sealed.format });
        }
        Ok((sealed, blake3::hash(&bytes).to_hex().to_string()))
    }

    /// The numbers that stand for seeds.
    pub fn numbers(&self) -> Vec<Seed> {
        (0..self.episodes.len() as u64).map(Seed).collect()
    }
}

impl Task {
    /// Reads what was published in a folder.
    pub fn read(folder: &Path) -> Result<Self, TaskError> {
        let (task, _): (Self, _) = read(folder.join(TASK))?;
        if task.format != FORMAT {
            return Err(TaskError::Format { path: folder.join(TASK), found: task.format });
        }
        Ok(task)
    }
}

fn read<T: DeserializeOwned>(path: PathBuf) -> Result<(T, Vec<u8>), TaskError> {
    let bytes = match read_regular(&path, LARGEST_FILE) {
        Ok(bytes) => bytes,
        Err(source) => return Err(TaskError::Read { path, source }),
    };
    match serde_json::from_slice(&bytes) {
        Ok(read) => Ok((read, bytes)),
        Err(source) => Err(TaskError::Json { path, source }),
    }
}

/// The seed of an episode: of the secret, which it does not give away.
pub fn drawn(secret: &str, episode: u64) -> Seed {
    let mut hasher = blake3::Hasher::new_derive_key("vantage 2026 task episode seed");
    hasher.update(&episode.to_le_bytes()).update(secret.as_bytes());
    let mut bytes = [0; 8];
    hasher.finalize_xof().fill(&mut bytes);
    Seed(u64::from_le_bytes(bytes))
}

/// What is published of what a robot observed, and of each detection its number among those of `given`.
pub fn published(given: &Observations, association: AssociationChoice) -> (Observations, Vec<usize>) {
    let told = match association {
        AssociationChoice::Given => return (given.clone(), (0..given.detections.len()).collect()),
        AssociationChoice::Tracklets => Told::Tracklets,
        AssociationChoice::None => Told::None,
    };
    let (tracklets, order) = told.of(given);
    let observations = tracklets.observations();
    let mut rows: Vec<(Detection, usize)> = observations.detections.iter().cloned().zip(order).collect();
    rows.sort_by_key(|(detection, _)| (detection.step, detection.track));
    let (detections, order) = rows.into_iter().unzip();
    (Observations { detections, ..observations.clone() }, order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_secret_draws_its_seeds_and_another_draws_others() {
        let seeds: BTreeSet<u64> =
            ["a", "b"].iter().flat_map(|secret| (0..100).map(|i| drawn(secret, i).0)).collect();
        assert_eq!(seeds.len(), 200);
        assert_eq!(drawn("a", 3), drawn("a", 3));
    }
}
