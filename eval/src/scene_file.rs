//! The scene file: YAML -> a checked scene, or every reason why not, with line and column.

use crate::seeds::Seeds;
use garde::Validate;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::Seed;
use vantage_learn::TrainingSpec;
use vantage_sim::scene::{
    CheckedScene, RobotSpec, SceneError, SceneSpec, SensorSpec, ViewsSpec, WorldSpec, fits_into,
};
use vantage_slam::EstimatorSpec;

/// A scene file is no larger than this, bytes.
pub const MAX_BYTES: u64 = 256 * 1024;
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
}

impl SceneFile {
    /// The simulated part of the scene that was read from `path`, with the meshes it names. A scene file that was
    /// read has passed the simulator's rules.
    pub fn checked(&self, path: &Path) -> Result<CheckedScene, SceneError> {
        let spec = SceneSpec {
            world: self.world.clone(),
            robot: self.robot.clone(),
            sensors: self.sensors.clone(),
            views: self.views.clone(),
        };
        CheckedScene::new(spec, path.parent().unwrap_or(Path::new("")))
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
}

/// Why a scene file is refused.
#[derive(Debug, Error)]
pub enum SceneFileError {
    /// It cannot be read.
    #[error("cannot read the scene {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is far larger than any scene.
    #[error(
        "the scene {} is larger than {MAX_BYTES} bytes: a scene is a page of YAML, is this the right file?",
        path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// It is not text.
    #[error("the scene {} is not UTF-8 text (byte {offset})", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// Offset of the first byte that is not.
        offset: usize,
    },
    /// It is no scene: the message holds line, column and a snippet for each reason.
    #[error("the scene {} is not valid:\n{message}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// All reasons.
        message: String,
    },
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

/// Reads and checks a scene file of any shape `T`. No more than [`MAX_BYTES`] are ever read.
pub fn read<T>(path: &Path) -> Result<T, SceneFileError>
where
    T: DeserializeOwned + Validate<Context = ()>,
{
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|source| SceneFileError::Unreadable { path: path.to_owned(), source })?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(SceneFileError::TooLarge { path: path.to_owned() });
    }
    let text = String::from_utf8(bytes).map_err(|error| SceneFileError::NotText {
        path: path.to_owned(),
        offset: error.utf8_error().valid_up_to(),
    })?;
    parse(&text, path)
}

/// Checks the text of a scene file; `path` is for messages only.
///
/// Unknown and doubled keys, NaN and infinities anywhere, aliases that explode and more than one document are refused.
/// Of the ranges, all that are violated are reported at once.
pub fn parse<T>(text: &str, path: &Path) -> Result<T, SceneFileError>
where
    T: DeserializeOwned + Validate<Context = ()>,
{
    let checked = serde_saphyr::from_str_with_options_valid::<T>(text, options()).and_then(|scene| {
        // Typed numbers take `.nan`, and ranges let it pass. Where a field has no rule against it, this is the wall:
        // read untyped, the file may hold no number that is not finite.
        serde_saphyr::from_str_with_options::<serde_json::Value>(text, options()).map(|_| scene)
    });
    checked.map_err(|error| {
        let name = path.to_string_lossy();
        let render = serde_saphyr::render_options! {
            formatter: &serde_saphyr::UserMessageFormatter,
            source_name: Some(name.as_ref()),
        };
        SceneFileError::Invalid { path: path.to_owned(), message: error.render_with_options(render) }
    })
}

fn options() -> serde_saphyr::Options {
    serde_saphyr::options! {
        budget: serde_saphyr::budget! { max_nodes: 20_000, max_depth: 32, max_aliases: 100 },
        duplicate_keys: serde_saphyr::options::DuplicateKeyPolicy::Error,
        non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::Reject,
        reject_unsupported_tags: true,
        strict_booleans: true,
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

    const GOOD: &str = "version: 1\nname: tabletop\npurpose: To show it.\nevaluation:\n  seeds: 10\n";

    /// The head of a scene, without the sections of the other rooms.
    #[derive(Clone, Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(deny_unknown_fields)]
    struct Head {
        #[garde(custom(is_known_version))]
        version: u32,
        #[garde(custom(is_file_name))]
        name: String,
        #[garde(length(min = 1, max = 1000))]
        purpose: String,
        #[garde(dive)]
        evaluation: EvaluationSpec,
    }

    /// A section such as the other rooms define.
    #[derive(Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(deny_unknown_fields)]
    struct World {
        #[garde(range(min = 0.01, max = 10.0))]
        mass: f64,
        #[garde(dive)]
        shapes: Vec<Shape>,
        #[serde(default)]
        #[garde(dive)]
        surface: Option<Surface>,
    }

    /// A choice that the YAML names by a key, and the path of a violation does not.
    #[derive(Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(rename_all = "snake_case", deny_unknown_fields)]
    enum Surface {
        Table {
            #[garde(range(min = 0.1))]
            height: f64,
        },
    }

    #[derive(Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
    enum Shape {
        Box {
            #[garde(range(min = 0.0))]
            side: f64,
        },
    }

    fn error<T: DeserializeOwned + Validate<Context = ()> + std::fmt::Debug>(yaml: &str) -> String {
        parse::<T>(yaml, Path::new("scenes/x.yaml")).unwrap_err().to_string()
    }

    #[test]
    fn a_scene_is_read_and_its_hash_ignores_comments_only() {
        let scene: Head = parse(GOOD, Path::new("x")).unwrap();
        assert_eq!(scene.evaluation.seeds.as_slice().len(), 10);
        let same: Head = parse(&format!("# why\n{GOOD}"), Path::new("y")).unwrap();
        let other: Head = parse(&GOOD.replace("10", "11"), Path::new("x")).unwrap();
        assert_eq!(hash(&scene).unwrap(), hash(&same).unwrap());
        assert_ne!(hash(&scene).unwrap(), hash(&other).unwrap());
    }

    #[test]
    fn each_fault_is_named_with_file_line_and_column() {
        let cases = [
            (GOOD.replace("purpose", "purposes"), "purposes", ":3:1"),
            (format!("{GOOD}name: again\n"), "name", ":6:1"),
            (GOOD.replace("seeds: 10", "seeds: ten"), "a number of seeds", ":5:"),
            (GOOD.replace("version: 1", "version: one"), "version", ":1:10"),
            (GOOD.replace("name: tabletop", "name: [tabletop"), "", ":"),
            (GOOD.replace("  seeds", "\tseeds"), "tab", ":5:"),
            (GOOD.replace("seeds: 10", "seeds: .nan"), ".nan", ":5:10"),
            (format!("{GOOD}---\n{GOOD}"), "document", ":"),
            (GOOD.replace("evaluation:\n  seeds: 10\n", ""), "evaluation", ":"),
        ];
        for (yaml, names, position) in cases {
            let message = error::<Head>(&yaml);
            assert!(message.contains(names), "{names:?} not in: {message}");
            assert!(message.contains(&format!("scenes/x.yaml{position}")), "{position} not in: {message}");
        }
        assert!(error::<Head>("").contains("end of file"));
    }

    #[test]
    fn all_violations_are_reported_at_once() {
        let yaml = GOOD.replace("version: 1", "version: 3").replace("tabletop", "../../etc");
        let message = error::<Head>(&yaml);
        assert!(message.contains("format 3 is unknown") && message.contains(":1:10"), "{message}");
        assert!(message.contains("is no scene name") && message.contains(":2:7"), "{message}");
    }

    #[test]
    fn violations_inside_lists_of_tagged_shapes_have_their_place() {
        let yaml = "mass: 0\nshapes:\n  - kind: box\n    side: 1\n  - kind: box\n    side: -2\n";
        let message = error::<World>(yaml);
        assert!(message.contains(":1:7"), "{message}");
        assert!(message.contains("shapes[1].side"), "{message}");
        let message = error::<World>("mass: 1\nshapes: []\nsurface:\n  table:\n    height: 0\n");
        assert!(message.contains(":4:3") && message.contains("surface.height"), "{message}");
        for mass in [".nan", "-.inf", ".inf", "1e999"] {
            let message = error::<World>(&format!("mass: {mass}\nshapes: []\n"));
            assert!(message.contains(":1:7"), "{message}");
        }
        assert!(error::<World>("mass: 1\nshapes: [{kind: ball}]\n").contains("ball"));
    }

    #[test]
    fn bombs_are_refused_without_being_read_or_expanded() {
        let mut bomb = String::from("a: &a [x, x, x, x, x, x, x, x, x]\n");
        for (name, inner) in
            [("b", "a"), ("c", "b"), ("d", "c"), ("e", "d"), ("f", "e"), ("g", "f"), ("h", "g")]
        {
            let aliases = vec![format!("*{inner}"); 9].join(", ");
            bomb += &format!("{name}: &{name} [{aliases}]\n");
        }
        let start = std::time::Instant::now();
        assert!(!error::<Head>(&bomb).is_empty());
        assert!(!error::<Head>(&"[".repeat(100_000)).is_empty());
        assert!(start.elapsed().as_secs() < 5);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.yaml");
        std::fs::write(&path, vec![b'#'; MAX_BYTES as usize + 1]).unwrap();
        assert!(matches!(read::<Head>(&path), Err(SceneFileError::TooLarge { .. })));
        std::fs::write(&path, [b'a', 0xff]).unwrap();
        assert!(matches!(read::<Head>(&path), Err(SceneFileError::NotText { offset: 1, .. })));
        let missing = read::<Head>(&folder.path().join("missing.yaml")).unwrap_err();
        assert!(missing.to_string().contains("missing.yaml"));
        assert!(matches!(read::<Head>(folder.path()), Err(SceneFileError::Unreadable { .. })));
    }

    #[test]
    fn the_schema_is_draft_07_and_closed() {
        let schema: serde_json::Value = serde_json::from_str(&schema::<SceneFile>().unwrap()).unwrap();
        assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
        assert_eq!(schema["additionalProperties"], false);
        assert_eq!(schema["properties"]["purpose"]["maxLength"], 1000);
        assert_eq!(schema["definitions"]["Seeds"]["oneOf"][0]["maximum"], 1000);
    }
}
