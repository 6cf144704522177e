//! What a row is given of an episode.

use crate::pipeline::{EpisodeFolder, StageError};
use std::cell::OnceCell;
use vantage_dataset::store::read_observations;
use vantage_dataset::{Detection, Observations};

/// An episode, and who is who on it. Observations are read once, where an answer is not in the cache.
pub struct RowInput<'e> {
    /// The episode.
    pub episode: &'e EpisodeFolder,
    /// Of each detection its object, where not the episode tells it.
    pub objects: Option<&'e [Option<usize>]>,
    observations: OnceCell<Observations>,
}

impl<'e> RowInput<'e> {
    /// An episode, with what is told of its detections by others.
    pub fn new(episode: &'e EpisodeFolder, objects: Option<&'e [Option<usize>]>) -> Self {
        Self { episode, objects, observations: OnceCell::new() }
    }

    /// What the robot observed.
    pub fn observations(&self) -> Result<&Observations, StageError> {
        if let Some(observations) = self.observations.get() {
            return Ok(observations);
        }
        let given = read_observations(&self.episode.folder)?;
        let seen = match self.objects {
            Some(objects) => with_objects(&given, objects),
            None => given,
        };
        Ok(self.observations.get_or_init(|| seen))
    }
}

/// Observations with an object told of each detection; those of nothing are left out.
pub fn with_objects(given: &Observations, objects: &[Option<usize>]) -> Observations {
    let detections = given.detections.iter().zip(objects);
    let mut detections: Vec<Detection> = detections
        .filter_map(|(detection, object)| Some(Detection { track: (*object)?, ..detection.clone() }))
        .collect();
    detections.sort_by_key(|detection| (detection.step, detection.track));
    Observations { detections, ..given.clone() }
}
