//! Stages of a study: variants trained on the same views, each under several seeds, and scored on the same instances.

use super::training::{Fit, fit};
use super::{LoadedModel, Pipeline, Unseen, code, load, unseen, views};
use crate::exit::BenchError;
use crate::scene_file;
use crate::study_file::{StudyFile, Variant};
use std::path::Path;
use vantage_dataset::store::Key;
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_learn::{MANIFEST, TrainingSpec};

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

/// The models of a variant, by seed; trained where the cache has none.
///
/// `trunks` is a folder of trained trunks, which variants share where their stage 1 is the same.
pub fn variant_models(
    pipeline: &Pipeline,
    study: &StudyFile,
    variant: &Variant,
    views: &StudyViews,
    trunks: &Path,
) -> Result<Vec<(Seed, LoadedModel)>, BenchError> {
    let spec: TrainingSpec = variant.training(&pipeline.file.training.model)?;
    let kept = variant.instances.unwrap_or(usize::MAX);
    let training = first_instances(&views.training, kept);
    let conditions = scene_file::hash(&(&views.seals, training.instances.len()))?;
    (1..=study.seeds)
        .map(|seed| {
            let seed = Seed(seed);
            let key = Key::new("study model", &(code::TRAINED, &conditions, seed, &spec))?;
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
            Ok((seed, load(pipeline, &entry.folder)?))
        })
        .collect()
}

/// Scores of a model, a set of test instances each.
pub fn variant_scores(pipeline: &Pipeline, model: &LoadedModel) -> Result<Vec<Unseen>, BenchError> {
    unseen(pipeline, pipeline.file.evaluation.seeds.as_slice(), model)
}

fn first_instances(set: &ViewSet, kept: usize) -> ViewSet {
    let views = set.views.iter().filter(|view| view.instance < kept);
    ViewSet {
        split: set.split,
        instances: set.instances.iter().take(kept).cloned().collect(),
        views: views.cloned().collect(),
    }
}
