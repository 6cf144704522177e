//! The study file: models that are trained on the views of one scene, each in its own way, and compared.

use super::is_file_name;
use crate::exit::Ends;
use crate::scene_file::row_name::{GAUSSIAN_PROCESS, MEAN_VIEW, PIXELS};
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::path::PathBuf;
use thiserror::Error;
use vantage_learn::TrainingSpec;

/// Version of the study format.
pub const VERSION: u32 = 1;

/// A whole study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Version of the study format: 1.
    #[garde(range(min = VERSION, max = VERSION))]
    pub version: u32,
    /// Name of the study and of its folder of results.
    #[garde(custom(is_file_name))]
    pub name: String,
    /// What the study is to show, in a sentence.
    #[garde(length(min = 1, max = 1000))]
    pub purpose: String,
    /// The scene, relative to the study: its views train and score the models, its `training.model` is what variants
    /// differ from.
    #[garde(skip)]
    pub scene: PathBuf,
    /// What models are scored on.
    #[serde(default)]
    #[garde(skip)]
    pub scored: Scored,
    /// A view set, as `bench import` makes them, that variants are trained on in place of the scene's training views; relative to the
    /// study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(custom(trains(&self.variants)))]
    pub training_views: Option<PathBuf>,
    /// Likewise, in place of the scene's validation views.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub validation_views: Option<PathBuf>,
    /// A view set, as `bench import` makes them, whose instances are scored in place of the scene's test instances; relative to the
    /// study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(custom(in_place_of_test(self.scored)))]
    pub views: Option<PathBuf>,
    /// A scene whose test instances are scored in place of those of `scene`; relative to the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(custom(in_place_of_test(self.scored)), custom(without(&self.views)))]
    pub scored_scene: Option<PathBuf>,
    /// Also scores how well azimuths are told of objects that were seen from so many known viewpoints, for each of these numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[garde(length(max = 8), inner(range(min = 1, max = 1000)))]
    pub known_views: Vec<usize>,
    /// Each variant is trained so often, with seeds from 1 on.
    #[garde(range(min = 1, max = 100))]
    pub seeds: u64,
    /// The variants; the first is what the others are compared with.
    #[garde(length(min = 1, max = 200), dive, custom(differ))]
    pub variants: Vec<Variant>,
}

/// What models are scored on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scored {
    /// A set of test instances for each of the scene's `evaluation.seeds`.
    #[default]
    Test,
    /// The validation instances, where settings are chosen by the scores. They calibrate the noise, too, so that the table of
    /// calibration promises too much.
    Validation,
    /// Instances that were trained on, as many as the scene has in a set of test instances, or all of `training_views`, from viewpoints
    /// that were not: of each of their sessions every fourth view is left out of the training.
    Known,
}

/// One way to train a model, or one that is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Its row in the table.
    #[garde(custom(is_file_name))]
    pub name: String,
    /// What it shows.
    #[garde(length(min = 1, max = 300))]
    pub note: String,
    /// Training instances, of those that the scene has: the first ones.
    #[serde(default)]
    #[garde(inner(range(min = 2)))]
    pub instances: Option<usize>,
    /// Trains on the first so many of the scene's families alone, beside composites.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub families: Option<usize>,
    /// Trains on so many composites at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub composites: Option<usize>,
    /// What differs from the scene's `training.model`.
    #[serde(default)]
    #[garde(skip)]
    pub model: Map<String, Value>,
    /// The folder of a model of any kind, relative to the study, in place of a training: scored once, its row is the same under all seeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub folder: Option<PathBuf>,
}

/// A variant that cannot be trained.
#[derive(Debug, Error)]
#[error("{}study variant {variant}: {reason}", place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default())]
pub struct VariantError {
    /// File, line and column, as far as they are known.
    pub place: Option<String>,
    /// Its name.
    pub variant: String,
    /// Which setting is wrong, and how.
    pub reason: String,
}

impl Ends for VariantError {}

fn in_place_of_test(scored: Scored) -> impl FnOnce(&Option<PathBuf>, &()) -> garde::Result {
    move |views, ()| match views {
        Some(_) if scored != Scored::Test => {
            Err(garde::Error::new("are scored in place of test instances: leave out `scored`"))
        }
        _ => Ok(()),
    }
}

fn trains(variants: &[Variant]) -> impl FnOnce(&Option<PathBuf>, &()) -> garde::Result + '_ {
    move |views, ()| match views {
        Some(_) if variants.iter().all(|variant| variant.folder.is_some()) => {
            Err(garde::Error::new("trains no variant, as each has a `folder`: leave it out"))
        }
        _ => Ok(()),
    }
}

fn without(views: &Option<PathBuf>) -> impl FnOnce(&Option<PathBuf>, &()) -> garde::Result + '_ {
    move |scene, ()| match (scene, views) {
        (Some(_), Some(_)) => Err(garde::Error::new("is there beside `views`: one of them is scored")),
        _ => Ok(()),
    }
}

impl Scored {
    /// For people.
    pub fn told(self) -> &'static str {
        match self {
            Self::Test => "instances that no training has seen",
            Self::Validation => "validation instances, which also calibrate the noise",
            Self::Known => "held-out views of training instances, from sessions that were trained on",
        }
    }
}

impl StudyFile {
    /// Hash of the study as read, on a scene of this hash, or of these two with a blank between, the one that is scored last: see [`super::hash`]. Where the scene's file lies does not enter it.
    pub fn hash(&self, scene_hash: &str) -> Result<String, serde_json::Error> {
        let anywhere = Self { scene: PathBuf::new(), scored_scene: None, ..self.clone() };
        super::hash(&(&anywhere, scene_hash))
    }
}

impl Variant {
    /// The refusal of its settings.
    pub fn refused(&self, reason: String) -> VariantError {
        VariantError { place: None, variant: self.name.clone(), reason }
    }

    /// Refuses to train on more instances than there are, or on fewer than are scored as known; and to train a model that is there.
    pub fn fits(&self, there: usize, known: usize) -> Result<(), VariantError> {
        let instances = self.instances.unwrap_or(there);
        let reason = match instances {
            _ if self.folder.is_some() && self.is_trained() => {
                "folder names a trained model: leave out instances, families, composites and model".to_owned()
            }
            _ if known > 0 && (self.families.is_some() || self.composites.is_some()) => {
                "families and composites leave out instances that are scored as known: leave them out"
                    .to_owned()
            }
            _ if instances > there => {
                format!("instances is {instances}, but there are {there} training instances")
            }
            _ if instances < known => {
                format!("instances is {instances}, but the first {known} are scored as known")
            }
            _ => return Ok(()),
        };
        Err(self.refused(reason))
    }

    fn is_trained(&self) -> bool {
        let chosen = self.instances.is_some() || self.families.is_some() || self.composites.is_some();
        chosen || !self.model.is_empty()
    }

    /// Refuses a model that is there where other instances than test instances are scored: those that the study trains on itself.
    pub fn allowed_under(&self, scored: Scored) -> Result<(), VariantError> {
        if self.folder.is_none() || scored == Scored::Test {
            return Ok(());
        }
        let reason = "folder names a finished model, which is scored on test instances alone: leave out `scored` of the study, or \
                      train the variant";
        Err(self.refused(reason.to_owned()))
    }

    /// The whole training, `base` but for what differs; of nested settings only those that are named.
    pub fn training(&self, base: &TrainingSpec) -> Result<TrainingSpec, VariantError> {
        let failed = |reason: String| self.refused(format!("model: {reason}"));
        let mut whole = serde_json::to_value(base).map_err(|error| failed(error.to_string()))?;
        merge(&mut whole, &Value::Object(self.model.clone()));
        let spec: TrainingSpec = serde_json::from_value(whole).map_err(|error| failed(error.to_string()))?;
        spec.validate().map_err(|report| failed(report.to_string()))?;
        Ok(spec)
    }
}

fn merge(into: &mut Value, from: &Value) {
    match (into, from) {
        (Value::Object(into), Value::Object(from)) => {
            for (key, value) in from {
                merge(into.entry(key.clone()).or_insert(Value::Null), value);
            }
        }
        (into, from) => *into = from.clone(),
    }
}

fn differ(variants: &[Variant], _: &()) -> garde::Result {
    if let Some(floor) =
        variants.iter().find(|variant| [PIXELS, MEAN_VIEW, GAUSSIAN_PROCESS].contains(&variant.name.as_str()))
    {
        return Err(garde::Error::new(format!("{:?} is the name of a floor's row", floor.name)));
    }
    let mut names = BTreeSet::new();
    match variants.iter().find(|variant| !names.insert(&variant.name)) {
        Some(twice) => Err(garde::Error::new(format!("{:?} is there twice", twice.name))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use std::path::Path;
    use vantage_learn::Objective;

    const GOOD: &str = "version: 1\nname: models\npurpose: To show it.\nscene: s.yaml\nseeds: 3\nvariants:\n\
        - { name: a, note: the base }\n\
        - { name: b, note: another, instances: 5, model: { objective: viewpoint_predictive, predictive: { source: 0 } } }\n";

    #[test]
    fn variants_differ_from_the_base_where_they_say_so() {
        let study: StudyFile = parse(GOOD, Path::new("x")).unwrap();
        let base = TrainingSpec { steps: 7, ..TrainingSpec::default() };
        assert_eq!(study.scored, Scored::Test);
        assert_eq!(study.variants[0].training(&base).unwrap(), base);
        let other = study.variants[1].training(&base).unwrap();
        assert_eq!((other.objective, other.steps), (Objective::ViewpointPredictive, 7));
        assert_eq!(other.predictive.source, 0.0);
        assert_eq!(other.predictive.pairs, base.predictive.pairs);
    }

    #[test]
    fn the_hash_is_of_the_scene_and_not_of_its_place() {
        let hash = |text: &str, scene| parse::<StudyFile>(text, Path::new("x")).unwrap().hash(scene).unwrap();
        assert_eq!(hash(GOOD, "abc"), hash(&GOOD.replace("s.yaml", "views/s.yaml"), "abc"));
        assert_ne!(hash(GOOD, "abc"), hash(GOOD, "abd"));
        assert_ne!(hash(GOOD, "abc"), hash(&GOOD.replace("seeds: 3", "seeds: 4"), "abc"));
    }

    #[test]
    fn wrong_settings_and_doubled_names_are_refused() {
        let error =
            parse::<StudyFile>(&GOOD.replace("name: b", "name: mean_view"), Path::new("x")).unwrap_err();
        assert!(error.to_string().contains("floor"), "{error}");
        let study: StudyFile = parse(&GOOD.replace("source", "sauce"), Path::new("x")).unwrap();
        let error = study.variants[1].training(&TrainingSpec::default()).unwrap_err().to_string();
        assert!(error.contains("variant b") && error.contains("sauce"), "{error}");
        let study: StudyFile = parse(&GOOD.replace("source: 0", "source: 2"), Path::new("x")).unwrap();
        let error = study.variants[1].training(&TrainingSpec::default()).unwrap_err().to_string();
        assert!(error.contains("source"), "{error}");
        assert!(study.variants[0].fits(48, 48).is_ok() && study.variants[1].fits(5, 5).is_ok());
        assert!(study.variants[0].fits(47, 48).is_err());
        for scored in [Scored::Test, Scored::Validation, Scored::Known] {
            assert!(study.variants.iter().all(|variant| variant.allowed_under(scored).is_ok()));
            let there = Variant { folder: Some("there".into()), ..study.variants[0].clone() };
            assert_eq!(there.allowed_under(scored).is_ok(), scored == Scored::Test, "{scored:?}");
        }
        let both =
            parse::<StudyFile>(&GOOD.replace("instances: 5", "folder: there"), Path::new("x")).unwrap();
        assert!(both.variants[1].fits(9, 0).unwrap_err().to_string().contains("folder"));
        for (there, known) in [(9, 6), (4, 0)] {
            let error = study.variants[1].fits(there, known).unwrap_err().to_string();
            assert!(error.contains("variant b: instances is 5"), "{error}");
        }
        let twice = parse::<StudyFile>(&GOOD.replace("name: b", "name: a"), Path::new("x")).unwrap_err();
        assert!(twice.to_string().contains("twice"), "{twice}");
    }
}
