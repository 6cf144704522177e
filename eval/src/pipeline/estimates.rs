//! Stage `estimate`: every row's posterior of an episode.

use super::{EpisodeFolder, LoadedModel, Pipeline, SeedEpisode, StageError, code};
use crate::result::table::Outcome;
use crate::score::object::ObjectEstimate;
use nalgebra::{Point3, UnitQuaternion};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vantage_dataset::store::{Key, read_observations};
use vantage_dataset::{Pose, Seed};
use vantage_slam::{Estimate, EstimateError, EstimatorSpec, Outcome as Ending, Row, estimate};

const FILE: &str = "answers.json";

#[derive(Serialize)]
struct Inputs<'a> {
    code: &'static str,
    episode: &'a str,
    model: &'a str,
    spec: &'a EstimatorSpec,
}

/// What one row's estimator answered on one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// The row.
    pub row: Row,
    /// How it ended.
    pub outcome: Outcome,
    /// The robot's pose at each step; empty where there is no answer.
    pub world_from_robot: Vec<Pose>,
    /// The objects by track, with their orientation where the row has one.
    pub objects: Vec<Option<StoredObject>>,
    /// Detections whose crop could not be used.
    pub dropped: usize,
}

/// A seed and the answers of all rows.
pub type SeedAnswers = (Seed, Vec<Answer>);

/// An object as it is stored.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredObject {
    position: Point3<f64>,
    rotation: Option<UnitQuaternion<f64>>,
}

impl Answer {
    /// The objects as the scores take them, one a true object.
    pub fn scored_objects(&self, objects: usize) -> Vec<Option<ObjectEstimate>> {
        let object = |index: usize| {
            let object = (*self.objects.get(index)?)?;
            Some(ObjectEstimate { center_in_world: object.position, rotation: object.rotation })
        };
        (0..objects).map(object).collect()
    }

    fn new(estimate: &Estimate) -> Self {
        let dropped = estimate.dropped_detections;
        Self {
            row: estimate.row,
            outcome: match estimate.outcome {
                Ending::Converged => Outcome::Done,
                ending => Outcome::Flagged(ending.to_string()),
            },
            world_from_robot: estimate.world_from_robot.clone(),
            objects: estimate
                .objects
                .iter()
                .map(|object| {
                    object.as_ref().map(|object| StoredObject {
                        position: Point3::from(object.position),
                        rotation: object.orientation.map(|o| o.world_from_object),
                    })
                })
                .collect(),
            dropped: dropped.non_finite + dropped.undefined_viewpoint,
        }
    }

    fn failed(row: Row, reason: String) -> Self {
        Self {
            row,
            outcome: Outcome::Failed(reason),
            world_from_robot: Vec::new(),
            objects: Vec::new(),
            dropped: 0,
        }
    }
}

/// The answers of all rows on all seeds, seeds in parallel; the result does not depend on how many threads there are.
pub fn estimates(
    pipeline: &Pipeline,
    episodes: &[SeedEpisode],
    model: &LoadedModel,
) -> Result<Vec<SeedAnswers>, StageError> {
    let stage = pipeline.progress.stage("estimates", episodes.len() as u64);
    let spec = &pipeline.file.estimator;
    let cache = &pipeline.cache;
    episodes
        .par_iter()
        .map(|(seed, episode)| {
            let answers = match episode {
                Err(reason) => spec.rows.iter().map(|&row| Answer::failed(row, reason.clone())).collect(),
                Ok(episode) => {
                    let inputs =
                        Inputs { code: code::ESTIMATED, episode: &episode.seal, model: &model.hash, spec };
                    let key = Key::new("estimate", &inputs)?;
                    cache.json(&key, FILE, || answer(episode, model, spec))?
                }
            };
            stage.advance(1);
            Ok((*seed, answers))
        })
        .collect()
}

/// What a row that panicked says.
pub const PANICKED: &str = "panicked, which is a bug in the estimator";

/// A row whose model fails on a crop, or that panics, has failed on the seed; the other rows stand.
fn answer(
    episode: &EpisodeFolder,
    model: &LoadedModel,
    spec: &EstimatorSpec,
) -> Result<Vec<Answer>, StageError> {
    let observations = read_observations(&episode.folder)?;
    spec.rows
        .iter()
        .map(|&row| {
            let run = || estimate(&observations, row, Some(&model.model), spec);
            match catch_unwind(AssertUnwindSafe(run)) {
                Ok(Ok(estimate)) => Ok(Answer::new(&estimate)),
                Ok(Err(error @ EstimateError::Model(_))) => Ok(Answer::failed(row, error.to_string())),
                Ok(Err(error)) => Err(error.into()),
                Err(_) => Ok(Answer::failed(row, PANICKED.to_owned())),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_round_trip_to_the_bit() {
        let pose = Pose::rotation(nalgebra::Vector3::new(0.1, 0.2, 0.3));
        let answer = Answer {
            row: Row::Geometric,
            outcome: Outcome::Done,
            world_from_robot: vec![pose],
            objects: vec![
                None,
                Some(StoredObject { position: Point3::new(0.1, 0.2, 0.3), rotation: Some(pose.rotation) }),
            ],
            dropped: 1,
        };
        let json = serde_json::to_string(&answer).unwrap();
        let read: Answer = serde_json::from_str(&json).unwrap();
        assert_eq!(serde_json::to_string(&read).unwrap(), json);
        assert_eq!(read.world_from_robot[0].rotation.coords, pose.rotation.coords);
    }
}
