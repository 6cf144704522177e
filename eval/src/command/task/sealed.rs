//! A task as it is published, and its sealed truth.

use super::error::TaskError;
use crate::command::cli::AssociationChoice;
use crate::scene_file::associator::Told;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
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
    /// What objects may be.
    pub classes: Vec<String>,
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

/// The seed of an episode: of the secret, which it does not give away, and of the task, so that one task tells nothing of another.
pub fn drawn(secret: &str, scene_hash: &str, association: AssociationChoice, episode: u64) -> Seed {
    let mut hasher = blake3::Hasher::new_derive_key("vantage 2026 task episode seed");
    let told = match association {
        AssociationChoice::Given => 0u8,
        AssociationChoice::Tracklets => 1,
        AssociationChoice::None => 2,
    };
    hasher.update(&episode.to_le_bytes()).update(&[told]).update(scene_hash.as_bytes());
    hasher.update(&[0]).update(secret.as_bytes());
    let mut bytes = [0; 8];
    hasher.finalize_xof().fill(&mut bytes);
    Seed(u64::from_le_bytes(bytes))
}

/// What is published of what a robot observed, and of each detection its number among those of `given`.
pub fn published(given: &Observations, association: AssociationChoice) -> (Observations, Vec<usize>) {
    let told = match association {
        AssociationChoice::Given => return renumbered(given),
        AssociationChoice::Tracklets => Told::Tracklets,
        AssociationChoice::None => Told::None,
    };
    let (tracklets, order) = told.of(given);
    let observations = tracklets.observations();
    let rows = observations.detections.iter().cloned().zip(order).collect();
    ordered(observations, rows)
}

/// Tracks numbered as they come, those of one step from left to right: which pedestal an object stands on, how many were never seen, and
/// which tracks show nothing, their numbers do not tell.
fn renumbered(given: &Observations) -> (Observations, Vec<usize>) {
    let mut order: Vec<usize> = (0..given.detections.len()).collect();
    let place = |i: &usize| (given.detections[*i].step, given.detections[*i].bounding_box.min.x);
    order.sort_by(|a, b| place(a).0.cmp(&place(b).0).then(place(a).1.total_cmp(&place(b).1)));
    let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
    let mut rows = Vec::with_capacity(order.len());
    for index in order {
        let next = numbers.len();
        let track = *numbers.entry(given.detections[index].track).or_insert(next);
        rows.push((Detection { track, ..given.detections[index].clone() }, index));
    }
    ordered(given, rows)
}

/// By step, then track, as episodes are stored.
fn ordered(observations: &Observations, mut rows: Vec<(Detection, usize)>) -> (Observations, Vec<usize>) {
    rows.sort_by_key(|(detection, _)| (detection.step, detection.track));
    let (detections, order) = rows.into_iter().unzip();
    (Observations { detections, ..observations.clone() }, order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_secret_draws_its_seeds_and_another_secret_scene_or_level_draws_others() {
        let of = |secret, scene, association| (0..100).map(move |i| drawn(secret, scene, association, i).0);
        let (given, none) = (AssociationChoice::Given, AssociationChoice::None);
        let seeds: BTreeSet<u64> = of("a", "s", given)
            .chain(of("b", "s", given))
            .chain(of("a", "t", given))
            .chain(of("a", "s", none))
            .collect();
        assert_eq!(seeds.len(), 400);
        assert_eq!(drawn("a", "s", given, 3), drawn("a", "s", given, 3));
    }
}
