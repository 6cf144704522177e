//! Stages of a study: variants trained on the same views, each under several seeds, and scored on the same instances.

use super::held_out::{held_out, recalled};
use super::known_views::{Teller, known_views};
use super::model::{any_model, check_unseen};
use super::training::{Fit, fit, shown_views};
use super::variant_views::of_variant;
use super::{Pipeline, ScoredViews, StageError, code, test_views, unseen};
use crate::scene_file;
use crate::scene_file::study::{Scored, StudyFile, Variant};
use crate::score::known_views::KnownViewTrial;
use crate::score::unseen::{Subject, Unseen};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::Arc;
use vantage_dataset::store::Key;
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_learn::{MANIFEST, Model, TrainError, TrainingDevice, TrainingSpec};

/// The views that a study trains on, and what identifies them.
pub struct StudyViews {
    training: ViewSet,
    validation: ViewSet,
    seals: [String; 2],
    scored: Vec<ScoredViews>,
    /// Of known instances, whose azimuths are asked, and of validation instances in the same way: [`recalled`].
    recalled: Option<[ScoredViews; 2]>,
    /// Whether the study scores instances that its trainings have seen.
    of_seen: bool,
}

/// View sets that were imported, in place of those that a scene renders.
#[derive(Clone, Debug, Default)]
pub struct ImportedViews {
    /// To train on.
    pub training: Option<ScoredViews>,
    /// To calibrate the noise on.
    pub validation: Option<ScoredViews>,
}

impl ImportedViews {
    /// How many instances a study can train on, how many of them it scores where it scores known ones, and whether a robot's odometry tells
    /// of their views.
    pub fn numbers(&self, pipeline: &Pipeline) -> (usize, usize, bool) {
        let spec = &pipeline.scene.view_conditions().views;
        match &self.training {
            None => (spec.instances(Split::Train), spec.instances(Split::Test), spec.odometry.is_some()),
            Some(ScoredViews { set, .. }) => {
                let sighted = set.views.iter().all(|view| view.sighting.is_some());
                (set.instances.len(), set.instances.len(), sighted)
            }
        }
    }
}

/// Renders the views that are needed, where the cache has none and none were imported: those to train on where a variant is trained,
/// those to validate on there and where azimuths are asked. `elsewhere` are scored in place of test instances.
pub fn study_views(
    pipeline: &Pipeline,
    study: &StudyFile,
    imported: ImportedViews,
    elsewhere: Option<Vec<ScoredViews>>,
) -> Result<StudyViews, StageError> {
    let tested = || match elsewhere {
        Some(views) => Ok(views),
        None => test_views(pipeline, pipeline.file.evaluation.seeds.as_slice()),
    };
    let finished = study.variants.iter().all(|variant| variant.folder.is_some());
    let seed = pipeline.file.training.seed;
    let (_, known, _) = imported.numbers(pipeline);
    let of = |needed: bool, imported: Option<ScoredViews>, split| match imported {
        _ if !needed => Ok((ViewSet { split, instances: Vec::new(), views: Vec::new() }, String::new())),
        Some(ScoredViews { set, seal, .. }) => Ok((set, seal)),
        None => shown_views(pipeline, split),
    };
    let (mut training, first) = of(!finished, imported.training, Split::Train)?;
    let is_asked = !study.known_views.is_empty();
    let (validation, second) = of(!finished || is_asked, imported.validation, Split::Validation)?;
    let mut both = None;
    let scored = match study.scored {
        Scored::Test => tested()?,
        Scored::Validation => vec![ScoredViews { seed, set: validation.clone(), seal: second.clone() }],
        Scored::Known => {
            let set = held_out(&mut training, known);
            let missing = (0..known).find(|&instance| set.views.iter().all(|view| view.instance != instance));
            if let Some(instance) = missing {
                return Err(StageError::NothingHeldOut { instance });
            }
            let seal = format!("held out of {known} instances of {first}");
            both = is_asked.then(|| {
                let mut kept = validation.clone();
                let held = held_out(&mut kept, validation.instances.len());
                let of = |set, seal: &str| ScoredViews {
                    seed,
                    set,
                    seal: format!("{seal}, beside those that are not held out"),
                };
                [of(recalled(&training, &set), &seal), of(recalled(&kept, &held), &second)]
            });
            vec![ScoredViews { seed, set, seal }]
        }
    };
    Ok(StudyViews {
        training,
        validation,
        seals: [first, second],
        scored,
        recalled: both,
        of_seen: study.scored != Scored::Test,
    })
}

impl StudyViews {
    /// What identifies all views.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let seals = self.seals.iter().chain(self.scored.iter().map(|scored| &scored.seal));
        seals.for_each(|seal| {
            hasher.update(seal.as_bytes());
        });
        hasher.finalize().to_hex().to_string()
    }

    /// Refuses a model that has seen what is scored. Where other instances than test instances are scored, all models are of the
    /// study's own trainings, and it asks for that.
    fn check_unseen(&self, model: &VariantModel, set: &ViewSet) -> Result<(), StageError> {
        if self.of_seen {
            return Ok(());
        }
        let instances = set.instances.iter().map(|instance| instance.id);
        check_unseen(model.model.training_instances(), &model.folder, instances)
    }

    /// Likewise, of a model that was trained elsewhere, before anything is trained.
    pub fn check_finished(&self, models: &VariantModels) -> Result<(), StageError> {
        let models = models.iter().filter_map(|(_, model)| model.as_ref().ok());
        models.take(1).try_for_each(|model| {
            self.scored.iter().try_for_each(|scored| self.check_unseen(model, &scored.set))
        })
    }

    /// The queries of a teller of azimuths, of objects with so many known views; of instances that were trained on these are views of the
    /// training. Its process is fitted on validation views, asked in the same way.
    pub fn known_views(
        &self,
        pipeline: &Pipeline,
        known: usize,
        teller: Teller<'_>,
    ) -> Result<Option<Vec<KnownViewTrial>>, StageError> {
        match &self.recalled {
            Some([asked, validation]) => known_views(
                pipeline,
                (&validation.set, &validation.seal),
                slice::from_ref(asked),
                known,
                teller,
            ),
            None => known_views(pipeline, (&self.validation, &self.seals[1]), &self.scored, known, teller),
        }
    }

    /// The first set of views whose azimuths are asked.
    pub fn first_asked(&self) -> Option<&ViewSet> {
        self.recalled.as_ref().map(|[asked, _]| asked).or(self.scored.first()).map(|asked| &asked.set)
    }

    /// The first set of views that models are scored on.
    pub fn first_scored(&self) -> Option<&ViewSet> {
        self.scored.first().map(|scored| &scored.set)
    }
}

/// One model of a variant.
pub struct VariantModel {
    /// The model.
    pub model: Arc<Model>,
    folder: PathBuf,
}

/// Models by the seed of their training, or why that failed.
pub type VariantModels = Vec<(Seed, Result<VariantModel, String>)>;

/// The models of a variant, by seed, or why a training failed; trained where the cache has none.
///
/// `trunks` is a folder of trained trunks, which variants share where their stage 1 is the same.
pub fn variant_models(
    pipeline: &Pipeline,
    study: &StudyFile,
    variant: &Variant,
    views: &StudyViews,
    trunks: &Path,
) -> Result<VariantModels, StageError> {
    let spec: TrainingSpec = variant.training(&pipeline.file.training.model)?;
    let families = &pipeline.scene.world().families;
    let training = of_variant(&views.training, variant, families);
    let chosen = (variant.families, variant.composites, training.instances.len(), training.views.len());
    let conditions = scene_file::hash(&(&views.seals, chosen))?;
    (1..=study.seeds)
        .map(|seed| {
            let seed = Seed(seed);
            let key = Key::new("study_model", &(code::TRAINED, &conditions, seed, &spec))?;
            let stored = pipeline.cache.entry(&key, |work| {
                if work.join(MANIFEST).exists() {
                    return Ok(());
                }
                pipeline.progress.note(&format!("training {} with seed {}", variant.name, seed.0));
                let fitted = Fit {
                    training: &training,
                    validation: &views.validation,
                    conditions: conditions.clone(),
                    spec: &spec,
                    seed,
                    trunks: Some(trunks),
                    device: &TrainingDevice::default(),
                };
                fit(pipeline, fitted, work)
            });
            let entry = match stored {
                Err(StageError::Train(failure @ TrainError::NonFiniteLoss { stage, step, loss, .. })) => {
                    pipeline
                        .progress
                        .note(&format!("{} with seed {} failed: {failure}", variant.name, seed.0));
                    return Ok((seed, Err(format!("the loss of stage {stage} is {loss} at step {step}"))));
                }
                stored => stored?,
            };
            let model = Arc::new(Model::load(&entry.folder)?);
            Ok((seed, Ok(VariantModel { model, folder: entry.folder })))
        })
        .collect()
}

/// A model that was trained elsewhere, in the place of one for each seed.
pub fn finished_model(
    pipeline: &Pipeline,
    folder: &Path,
    seeds: &[Seed],
) -> Result<VariantModels, StageError> {
    let (model, folder) = any_model(pipeline, Some(folder))?;
    let model = Arc::new(model);
    let of_seed = |&seed| (seed, Ok(VariantModel { model: Arc::clone(&model), folder: folder.clone() }));
    Ok(seeds.iter().map(of_seed).collect())
}

/// Scores of a model, on each set of the study's instances.
pub fn variant_scores(
    pipeline: &Pipeline,
    views: &StudyViews,
    trained: &VariantModel,
) -> Result<Vec<Unseen>, StageError> {
    let model = &trained.model;
    let subject = model.viewing().map_or(Subject::Embedding(model), Subject::Viewing);
    views.scored.iter().try_for_each(|scored| views.check_unseen(trained, &scored.set))?;
    unseen(pipeline, &views.scored, subject, model.hash())
}
