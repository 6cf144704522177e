//! `episodes.json`: how much there is of each seed, which spares a resumed run from making it again.

use crate::command::error::BenchError;
use crate::result::output_folder::OutputFolder;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::store::{Provenance, read_regular};
use vantage_dataset::{Episode, Seed};

const NAME: &str = "episodes.json";
const LARGEST: u64 = 64 << 20;

/// Counts by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Index {
    provenance: Provenance,
    episodes: BTreeMap<u64, Counts>,
}

/// What an episode holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Images.
    pub images: u64,
    /// Crops of objects.
    pub crops: u64,
}

impl Index {
    /// What an earlier run left; nothing where there was none, or one of other data.
    pub fn read(out: &OutputFolder, provenance: Provenance) -> Self {
        let left = read_regular(&out.path().join(NAME), LARGEST).ok();
        let left: Option<Self> = left.and_then(|text| serde_json::from_slice(&text).ok());
        let fits = left.filter(|index| index.provenance == provenance);
        fits.unwrap_or(Self { provenance, episodes: BTreeMap::new() })
    }

    /// The counts of a seed that was made before.
    pub fn get(&self, seed: Seed) -> Option<Counts> {
        self.episodes.get(&seed.0).copied()
    }

    /// Whether episodes were made, and none of them shows anything.
    pub fn is_without_crops(&self) -> bool {
        !self.episodes.is_empty() && self.episodes.values().all(|counts| counts.crops == 0)
    }

    /// Counts an episode.
    pub fn count(&mut self, episode: &Episode) {
        let detections = episode.observations.detections.iter().enumerate();
        let crops = detections.filter_map(|(number, d)| episode.truth.shown(number, d)).count();
        let counts = Counts { images: episode.observations.steps() as u64, crops: crops as u64 };
        self.episodes.insert(episode.seed.0, counts);
    }

    /// Writes it.
    pub fn write(&self, out: &OutputFolder) -> Result<(), BenchError> {
        Ok(out.write(NAME, &serde_json::to_vec_pretty(self)?)?)
    }
}
