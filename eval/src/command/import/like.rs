//! Odometry and detections of imported episodes as a scene's robot would have had them.

use crate::command::error::BenchError;
use crate::scene_file::{self, SceneFile};
use std::path::Path;
use vantage_dataset::{Episode, Observations, Seed};
use vantage_formats::DetectionLimits;
use vantage_sim::scene::SensorSpec;
use vantage_sim::sensor::odometry::measure;

/// The sensors to be like.
pub(super) struct Like(SensorSpec);

impl Like {
    pub(super) fn read(scene: &Path) -> Result<Self, BenchError> {
        let file: SceneFile = scene_file::read(scene)?;
        Ok(Self(file.sensors))
    }

    pub(super) fn limits(&self) -> DetectionLimits {
        let detector = &self.0.detector;
        DetectionLimits {
            min_visible_fraction: detector.min_visible_fraction,
            min_mask_pixels: detector.min_mask_pixels,
        }
    }

    /// The episode with noise on its odometry.
    pub(super) fn driven(&self, episode: &Episode, seed: Seed) -> Episode {
        let odometry = measure(&self.0.odometry, &episode.truth.world_from_robot, None, seed);
        let observations = Observations { odometry, ..episode.observations.clone() };
        Episode { seed, observations, truth: episode.truth.clone() }
    }

    /// Each episode so many times, with seeds from 0 on.
    pub(super) fn drawn(&self, episodes: &[(String, Episode)], draws: u64) -> Vec<(String, Episode)> {
        let all = episodes.iter().flat_map(|episode| (0..draws).map(move |_| episode));
        let drawn =
            all.zip(0..).map(|((name, episode), seed)| (name.clone(), self.driven(episode, Seed(seed))));
        drawn.collect()
    }
}
