//! The scene file: YAML -> a checked scene, or every reason why not, with line and column.

pub mod associator;
mod error;
pub mod estimator;
pub mod hypothesis;
mod kind;
pub mod life;
pub mod map;
pub mod panel;
mod place;
mod range;
mod read;
pub mod row;
pub mod row_name;
pub mod seeds;
pub mod study;
pub mod vary;
mod words;

pub use error::SceneFileError;
pub use kind::FileKind;
pub use place::{misfit, place_of_variant};
pub use read::{parse, read};

use crate::code::SIMULATED;
use crate::progress::{Progress, Stage};
use estimator::EstimatorSpec;
use garde::Validate;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use seeds::Seeds;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use vantage_dataset::Seed;
use vantage_learn::TrainingSpec;
use vantage_sim::checked::{CheckedScene, SceneError, SceneSpec, fits_into};
use vantage_sim::error::{Progress as Told, Stage as Reading};
use vantage_sim::scene::{RobotSpec, SensorSpec, ViewsSpec, WorldSpec};
use vary::Axis;

/// A scene file is no larger than this, bytes.
pub const MAX_BYTES: u64 = 256 * 1024;

/// The folder of prepared meshes in the cache.
const MESHES: &str = "meshes";

/// Version of the scene format.
pub const VERSION: u32 = 1;

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Version of the scene format: 1.
    #[garde(custom(is_known_version))]
    pub version: u32,
    /// Name of the scene and of its folder of results: lower-case letters, digits, `_` and `-`.
    #[garde(custom(is_file_name))]
    pub name: String,
    /// What the scene is to show, in a sentence.
    #[garde(length(min = 1, max = 1000))]
    pub purpose: String,
    /// What there is to see.
    #[garde(dive)]
    pub world: WorldSpec,
    /// The robot.
    #[garde(dive, custom(fits_into(&self.world)))]
    pub robot: RobotSpec,
    /// Its sensors.
    #[garde(dive)]
    pub sensors: SensorSpec,
    /// Views of single objects: those that the model is trained on, and those it is scored on.
    #[garde(dive)]
    pub views: ViewsSpec,
    /// The observation model.
    #[garde(dive)]
    pub training: TrainingSection,
    /// The estimator.
    #[garde(dive)]
    pub estimator: EstimatorSpec,
    /// What is scored.
    #[garde(dive)]
    pub evaluation: EvaluationSpec,
    /// One or two fields over several values each: `bench SCENE` then runs every combination, all under the same seeds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[garde(length(max = 2), dive)]
    pub vary: Vec<Axis>,
}

impl SceneFile {
    /// Refuses a scene whose episodes were recorded, for a command that asks of the simulated world alone.
    pub fn check_simulated(&self, path: &Path) -> Result<(), SceneFileError> {
        match self.evaluation.episodes {
            Some(_) => Err(SceneFileError::Recorded { path: path.to_owned() }),
            None => Ok(()),
        }
    }

    /// The simulated part of the scene that was read from `path`, with the meshes it names, which are prepared in the folder
    /// `cache` that commands keep finished stages in. A scene file that was read has passed the simulator's rules, but for those
    /// on what stands where. Tells of fields that vary: they do not here.
    pub fn checked(
        &self,
        path: &Path,
        cache: &Path,
        progress: &Progress,
    ) -> Result<CheckedScene, SceneFileError> {
        if !self.vary.is_empty() {
            let fields: Vec<&str> = self.vary.iter().map(|axis| axis.field.as_str()).collect();
            let fields = fields.join(" and ");
            progress.note(&format!("{} varies {fields}: taken here as the rest of it says", path.display()));
        }
        let spec = SceneSpec {
            world: self.world.clone(),
            robot: self.robot.clone(),
            sensors: self.sensors.clone(),
            views: self.views.clone(),
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        // What other code prepared is not taken.
        let shelf = cache.join(MESHES).join(SIMULATED);
        CheckedScene::new(spec, folder, Some(&shelf), &mut reading(progress)).map_err(|error| match error {
            SceneError::Placement(misplaced) => {
                let message = place::locate(&misplaced, path);
                SceneFileError::Invalid { path: path.to_owned(), message }
            }
            source => SceneFileError::Rules { path: path.to_owned(), source },
        })
    }
}

/// Shows how far the reading of meshes and furniture is.
fn reading(progress: &Progress) -> impl FnMut(Told) {
    let mut shown: Option<(Told, Stage)> = None;
    move |told| {
        if shown.as_ref().is_none_or(|(last, _)| last.stage != told.stage) {
            let name = if told.stage == Reading::Meshes { "meshes" } else { "fixtures" };
            shown = Some((Told { done: 0, ..told }, progress.stage(name, told.total)));
        }
        if let Some((last, stage)) = &mut shown {
            stage.advance(told.done - last.done);
            *last = told;
        }
    }
}

/// Where the observation model comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct TrainingSection {
    /// Seed of the training views and of the training.
    #[garde(skip)]
    #[schemars(with = "u64")]
    pub seed: Seed,
    /// Folder of a trained model, relative to the scene file; without it, or with `--train`, one is trained.
    #[serde(default)]
    #[garde(skip)]
    pub reference: Option<PathBuf>,
    /// How a model is trained.
    #[serde(default)]
    #[garde(dive)]
    pub model: TrainingSpec,
}

/// What is scored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct EvaluationSpec {
    /// The seeds, each one episode.
    #[garde(skip)]
    pub seeds: Seeds,
    /// Folder of episodes that were recorded, as `bench import` writes them, relative to the scene file: `SEED` each. They take the place of
    /// simulated ones, so that world and robot are of no account.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub episodes: Option<PathBuf>,
}

fn is_known_version(version: &u32, _: &()) -> garde::Result {
    if *version == VERSION {
        Ok(())
    } else {
        Err(garde::Error::new(format!("scene format {version} is unknown, this program reads {VERSION}")))
    }
}

pub(crate) fn is_file_name(name: &str, _: &()) -> garde::Result {
    let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_' || b == b'-';
    if (1..=64).contains(&name.len()) && name.bytes().all(allowed) {
        Ok(())
    } else {
        Err(garde::Error::new(format!(
            "{name:?} is no scene name: expected 1 to 64 lower-case letters, digits, _ and -"
        )))
    }
}

/// Hash of a scene as read: comments and spelling do not enter it, every value does.
pub fn hash<T: Serialize>(scene: &T) -> Result<String, serde_json::Error> {
    Ok(blake3::hash(&serde_json::to_vec(scene)?).to_hex().to_string())
}

/// The JSON schema of a scene file of shape `T`, draft 07, which is what editors read.
pub fn schema<T: JsonSchema>() -> Result<String, serde_json::Error> {
    let schema = SchemaSettings::draft07().into_generator().into_root_schema_for::<T>();
    Ok(serde_json::to_string_pretty(&schema)? + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_is_draft_07_and_closed() {
        let schema: serde_json::Value = serde_json::from_str(&schema::<SceneFile>().unwrap()).unwrap();
        assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
        assert_eq!(schema["additionalProperties"], false);
        assert_eq!(schema["properties"]["purpose"]["maxLength"], 1000);
        assert_eq!(schema["definitions"]["Seeds"]["oneOf"][0]["maximum"], 1000);
    }
}
