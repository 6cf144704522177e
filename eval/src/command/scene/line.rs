//! The line of `bench SCENE`: scene -> sim -> dataset -> learn -> slam -> eval -> results.

use super::record::Record;
use crate::command::cli::StageArgs;
use crate::command::error::BenchError;
use crate::pipeline::{
    LoadedModel, Pipeline, SeedAnswers, SeedEpisode, StageError, chosen_model, episodes, estimates, model,
    tables, test_views, unseen,
};
use crate::result::manifest::Manifest;
use crate::result::results_file::Results;
use crate::result::row_name::{semantic_row, taken_names};
use crate::scene_file::SceneFile;
use crate::score::entry::Entry;
use crate::score::unseen::{Subject, Unseen};
use std::path::Path;
use vantage_dataset::store::read_truth;
use vantage_dataset::{Seed, Split};

/// Runs the line on a scene.
pub fn line(scene: &Path, stages: &StageArgs) -> Result<Scored, BenchError> {
    let pipeline = Pipeline::open(scene, &stages.cache, stages.renderer.into())?;
    let seeds = seeds(&pipeline.file, stages);
    let entries = entries(&pipeline, stages, &seeds)?;
    let chosen = chosen_model(&pipeline, stages.train, stages.model.as_deref())?;
    let mut record = Record::begin(&pipeline, &seeds, stages)?;

    let views = record.timed("test views", || test_views(&pipeline, &seeds))?;
    let model = record.timed("model", || {
        let model = model(&pipeline, chosen.as_deref())?;
        views.iter().try_for_each(|views| model.check_set(&views.set))?;
        Ok::<_, StageError>(model)
    })?;
    let (episodes, answers) = drive(&pipeline, &seeds, &model, &mut record)?;
    let viewing = model.model.viewing();
    let unseen = record
        .timed("unseen instances", || unseen(&pipeline, &views, Subject::Viewing(&*viewing), &model.hash))?;
    let tables = tables(&pipeline, &seeds, &entries, &episodes, &answers, &unseen, &model)?;

    Ok(Scored {
        results: Results::new(&pipeline.file.name, &pipeline.scene_hash, tables.tables),
        detections: tables.detections,
        semantic_row: semantic_row(model.model.inner().manifest()),
        manifest: record.finish(&pipeline, &model, &entries, &episodes, &views)?,
        episodes,
        answers,
        entries,
        unseen,
    })
}

/// Episodes of objects that the model has not seen, and every estimator's answers; none where no robot drives.
fn drive(
    pipeline: &Pipeline,
    seeds: &[Seed],
    model: &LoadedModel,
    record: &mut Record,
) -> Result<(Vec<SeedEpisode>, Vec<SeedAnswers>), BenchError> {
    if !pipeline.drives() {
        let told = "note: no robot drives in this scene: single views are scored, and no trajectory";
        pipeline.progress.note(told);
        return Ok(Default::default());
    }
    let episodes = record.timed("episodes", || episodes(pipeline, seeds, Split::Test))?;
    let answers = record.timed("estimates", || {
        for episode in episodes.iter().filter_map(|(_, episode)| episode.as_ref().ok()) {
            model.check_unseen(read_truth(&episode.folder)?.objects.iter().map(|object| object.instance))?;
        }
        estimates(pipeline, &episodes, model)
    })?;
    Ok((episodes, answers))
}

/// Trajectories of other estimators that are scored beside ours.
fn entries(pipeline: &Pipeline, stages: &StageArgs, seeds: &[Seed]) -> Result<Vec<Entry>, BenchError> {
    match stages.trajectories.first() {
        Some(folder) if !pipeline.drives() => Err(Entry::undriven(folder).into()),
        _ => Ok(Entry::open(&stages.trajectories, &taken_names(), seeds, &pipeline.progress)?),
    }
}

/// The seeds that are asked for.
pub fn seeds(file: &SceneFile, stages: &StageArgs) -> Vec<Seed> {
    match stages.seeds {
        Some(count) => (0..count).map(Seed).collect(),
        None => file.evaluation.seeds.as_slice().to_vec(),
    }
}

/// All that the line gave for one scene.
pub struct Scored {
    /// The tables.
    pub results: Results,
    /// Their origin.
    pub manifest: Manifest,
    /// The episodes by seed, or why there is none; empty where no robot drives.
    pub episodes: Vec<SeedEpisode>,
    /// The estimators' answers by seed.
    pub answers: Vec<SeedAnswers>,
    /// Estimators of others.
    pub entries: Vec<Entry>,
    /// Scores on unseen instances, one a seed.
    pub unseen: Vec<Unseen>,
    /// Detections of objects in all episodes.
    pub detections: usize,
    /// Name of the semantic row.
    pub semantic_row: &'static str,
}

impl Scored {
    /// The model's likelihood against the azimuth's offset, mean over the seeds that have one; empty without any.
    pub fn likelihood(&self) -> Vec<(f64, f64)> {
        let curves: Vec<_> = self.unseen.iter().filter(|seed| !seed.likelihood.is_empty()).collect();
        let Some(first) = curves.first() else { return Vec::new() };
        let mean =
            |i: usize| curves.iter().map(|seed| seed.likelihood[i].1).sum::<f64>() / curves.len() as f64;
        first.likelihood.iter().enumerate().map(|(i, (offset, _))| (*offset, mean(i))).collect()
    }
}
