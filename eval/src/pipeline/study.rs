//! Stages of a study: variants trained on the same views, each under several seeds, and scored on the same instances.

use super::model::check_unseen;
use super::training::{Fit, fit};
use super::{Pipeline, Subject, Unseen, code, unseen, views};
use crate::exit::BenchError;
use crate::scene_file;
use crate::study_file::{StudyFile, Variant};
use std::path::{Path, PathBuf};
use vantage_dataset::store::Key;
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_learn::{MANIFEST, Model, TrainingSpec};

/// The views that a study trains on, and what identifies them.
pub struct StudyViews {
    training: ViewSet,
    validation: ViewSet,
    seals: [String; 2],
}

/// Renders the views, where the cache has none.
pub fn study_views(pipeline: &Pipeline) -> Result<StudyViews, BenchError> {
    let seed = pipeline.file.training.seed;
    let (training, first) = views(pipeline, Split::Train, seed, &mut |_| ())?;
    let (validation, second) = views(pipeline, Split::Validation, seed, &mut |_| ())?;
    Ok(StudyViews { training, validation, seals: [first, second] })
}

/// One model of a variant.
pub struct VariantModel {
    /// Seed of its training.
    pub seed: Seed,
    model: Model,
    folder: PathBuf,
}

/// The models of a variant, by seed; trained where the cache has none.
///
/// `trunks` is a folder of trained trunks, which variants share where their stage 1 is the same.
pub fn variant_models(
    pipeline: &Pipeline,
    study: &StudyFile,
    variant: &Variant,
    views: &StudyViews,
    trunks: &Path,
) -> Result<Vec<VariantModel>, BenchError> {
    let spec: TrainingSpec = variant.training(&pipeline.file.training.model)?;
    let kept = variant.instances.unwrap_or(usize::MAX);
    let training = first_instances(&views.training, kept);
    let conditions = scene_file::hash(&(&views.seals, training.instances.len()))?;
    (1..=study.seeds)
        .map(|seed| {
            let seed = Seed(seed);
            let key = Key::new("study_model", &(code::TRAINED, &conditions, seed, &spec))?;
            let entry = pipeline.stored(&key, |work| {
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
                };
                fit(pipeline, fitted, work)
            })?;
            Ok(VariantModel { seed, model: Model::load(&entry.folder)?, folder: entry.folder })
        })
        .collect()
}

/// Scores of a model, a set of test instances each.
pub fn variant_scores(pipeline: &Pipeline, trained: &VariantModel) -> Result<Vec<Unseen>, BenchError> {
    let VariantModel { model, folder, .. } = trained;
    let viewing = model.viewing();
    let subject = viewing.as_deref().map_or(Subject::Embedding(model), Subject::Viewing);
    unseen(pipeline, pipeline.file.evaluation.seeds.as_slice(), subject, model.hash(), |set| {
        check_unseen(model.training_instances(), folder, set.instances.iter().map(|instance| instance.id))
    })
}

fn first_instances(set: &ViewSet, kept: usize) -> ViewSet {
    let views = set.views.iter().filter(|view| view.instance < kept);
    ViewSet {
        split: set.split,
        instances: set.instances.iter().take(kept).cloned().collect(),
        views: views.cloned().collect(),
    }
}
