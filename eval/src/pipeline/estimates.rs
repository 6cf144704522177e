//! Stage `estimate`: every row's posterior of an episode.

mod answer;
mod drive;
mod row_input;

pub use answer::{Answer, StoredObject};
pub use row_input::with_objects;

use super::azimuth_sensor::AzimuthSensor;
use super::found::Finding;
use super::model::last_layer;
use super::object_process::processes;
use super::stage_cache::StageCache;
use super::true_views::true_views;
use super::{EpisodeFolder, LoadedModel, ModelRefusal, Pipeline, SeedEpisode, StageError, code};
use crate::scene_file::estimator::EstimatorSpec;
use crate::scene_file::row::{Reader, Row};
use drive::{Drive, driven};
use rayon::prelude::*;
use row_input::RowInput;
use serde::Serialize;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use vantage_dataset::store::{Key, read_truth};
use vantage_dataset::{Observations, Seed};
use vantage_learn::DecoderLastLayer;
use vantage_learn::residual_process::ResidualProcess;
use vantage_model::{LastLayer, ObservationModel};
use vantage_slam::{EstimateError, Lesson, PROCESSES, SeenView};

const FILE: &str = "answer.json";

/// Noise of the ideal sensor, radians: two degrees.
const IDEAL_SIGMA: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// A row of the table of trajectories, and what it is of.
#[derive(Clone, Copy)]
pub struct Method<'m> {
    /// The estimator.
    pub row: Row,
    /// What it reads crops by.
    pub model: &'m LoadedModel,
}

impl Method<'_> {
    /// Its name: the model's, of an estimator that there is one of for each.
    pub fn name(&self) -> String {
        if self.row.is_of_model() { self.model.name.clone() } else { self.row.to_string() }
    }
}

/// The methods of a scene's rows: one for each model of a row of models, one of any other, by the first model.
pub fn methods<'m>(rows: &[Row], models: &'m [LoadedModel]) -> Vec<Method<'m>> {
    let of_row = |&row: &Row| {
        let of = if row.is_of_model() { models } else { &models[..models.len().min(1)] };
        of.iter().map(move |model| Method { row, model })
    };
    rows.iter().flat_map(of_row).collect()
}

#[derive(Serialize)]
struct Inputs<'a> {
    code: &'static str,
    episode: &'a str,
    /// Of each detection its object, where not the episode tells it.
    #[serde(skip_serializing_if = "Option::is_none")]
    objects: Option<&'a [Option<usize>]>,
    model: &'a str,
    /// What identifies the views that the read-outs are fitted on, where the row reads one.
    #[serde(skip_serializing_if = "Option::is_none")]
    readouts: Option<&'a str>,
    /// What identifies the views that the process beside the model is fitted on, where the row has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    process: Option<&'a str>,
    /// With one row.
    spec: EstimatorSpec,
}

/// The answers on a seed, in the order of the methods.
pub type SeedAnswers = (Seed, Vec<Answer>);

/// What each row that learns was taught, seed by seed.
pub type Lessons = BTreeMap<Row, Vec<Lesson>>;

/// The answers of all methods on all seeds, seeds in parallel; the result does not depend on how many threads there are.
pub fn estimates(
    pipeline: &Pipeline,
    episodes: &[SeedEpisode],
    methods: &[Method<'_>],
) -> Result<Vec<SeedAnswers>, StageError> {
    Ok(drives(pipeline, episodes, methods, (None, None))?.0)
}

/// Likewise, of drives that go on from what those `before` taught, of none where there is none for a row; and what they teach. Where who is
/// who is `found`, the episodes do not tell it: rows are told the likeliest way, and those that learn, learn by all.
pub fn drives(
    pipeline: &Pipeline,
    episodes: &[SeedEpisode],
    methods: &[Method<'_>],
    (before, found): (Option<&Lessons>, Option<&[Finding]>),
) -> Result<(Vec<SeedAnswers>, Lessons), StageError> {
    let stage = pipeline.progress.stage("estimates", episodes.len() as u64);
    let spec = &pipeline.file.estimator;
    let cache = &pipeline.cache;
    let on_seed = |(index, (seed, episode)): (usize, &SeedEpisode)| {
        let ways = match (episode, found.map(|found| &found[index])) {
            (Ok(episode), None) => Ok(vec![(1.0, RowInput::new(episode, None))]),
            (Ok(episode), Some(Ok(found))) => {
                let ways = found.ways.iter();
                Ok(ways.map(|way| (way.weight, RowInput::new(episode, Some(&way.objects)))).collect())
            }
            (Err(reason), _) | (Ok(_), Some(Err(reason))) => Err(reason),
        };
        let of_method = |method: &Method<'_>| {
            let known = || before?.get(&method.row)?.get(index).cloned();
            let before = before.filter(|_| method.row.learns()).map(|_| known().unwrap_or_default());
            match (&ways, before) {
                (Err(reason), lesson) => Ok(Drive { answer: Answer::failed((*reason).clone()), lesson }),
                (Ok(ways), Some(before)) => driven(cache, ways, (method, spec), &before),
                (Ok(ways), None) => {
                    let (_, likeliest) = ways.first().expect("at least one");
                    Ok(Drive { answer: answered(cache, likeliest, method, spec)?, lesson: None })
                }
            }
        };
        let driven = methods.iter().map(of_method).collect::<Result<Vec<Drive>, StageError>>()?;
        stage.advance(1);
        Ok((*seed, driven))
    };
    let driven = episodes.par_iter().enumerate().map(on_seed).collect::<Result<Vec<_>, StageError>>()?;
    let mut lessons = Lessons::new();
    let mut answers = Vec::with_capacity(driven.len());
    for (seed, of_seed) in driven {
        let mut of_methods = Vec::with_capacity(of_seed.len());
        for (method, Drive { answer, lesson }) in methods.iter().zip(of_seed) {
            of_methods.push(answer);
            lesson.into_iter().for_each(|lesson| lessons.entry(method.row).or_default().push(lesson));
        }
        answers.push((seed, of_methods));
    }
    Ok((answers, lessons))
}

fn layer_of<'m>(method: &Method<'m>) -> Result<Option<DecoderLastLayer<'m>>, StageError> {
    let LoadedModel { model, folder, .. } = method.model;
    Ok(if method.row.learns_layer() { Some(last_layer(model, folder)?) } else { None })
}

fn processes_of<'m>(method: &Method<'m>) -> Result<Option<[ResidualProcess<'m>; PROCESSES]>, StageError> {
    let tried = method.row.tries_processes().then(|| processes(method.model.viewing()));
    Ok(tried.transpose()?)
}

/// What a row that is taught by the truth learns of a drive.
fn seen_in_truth(
    observations: &Observations,
    episode: &EpisodeFolder,
    method: &Method<'_>,
) -> Result<Option<Vec<SeenView>>, StageError> {
    if !method.row.is_taught() {
        return Ok(None);
    }
    let truth = read_truth(&episode.folder)?;
    Ok(Some(true_views(observations, &truth, method.model.viewing()).map_err(ModelRefusal::Answer)?))
}

/// The answer of a method on an episode, from the cache where that has it.
fn answered(
    cache: &StageCache,
    given: &RowInput<'_>,
    method: &Method<'_>,
    spec: &EstimatorSpec,
) -> Result<Answer, StageError> {
    let spec = spec.of_row(method.row);
    let (code, model) = (code::ESTIMATED, method.model.model.hash());
    let fitted_on = method.model.readouts.as_ref().map(|(_, seal)| seal.as_str());
    let readouts = fitted_on.filter(|_| method.row.reads_out());
    let beside = method.model.process.as_ref().map(|(_, seal)| seal.as_str());
    let process = beside.filter(|_| method.row.has_process());
    let (episode, objects) = (given.episode, given.objects);
    let inputs =
        Inputs { code, episode: &episode.seal, objects, model, readouts, process, spec: spec.clone() };
    let key = Key::new("estimate", &inputs)?;
    cache.json(&key, FILE, || {
        let observations = given.observations()?;
        let ideal = match method.row.reads_truth() {
            true => {
                let truth = read_truth(&episode.folder)?;
                Some(AzimuthSensor::new(observations, &truth, IDEAL_SIGMA))
            }
            false => None,
        };
        let views = seen_in_truth(observations, episode, method)?;
        answer(observations, method, (ideal.as_ref(), views.as_deref()), &spec)
    })
}

/// What a row that panicked says.
pub const PANICKED: &str = "panicked, which is a bug in the estimator";

/// A method whose model fails on a crop, or that panics, has failed on the seed; the others stand.
fn answer(
    observations: &Observations,
    method: &Method<'_>,
    (ideal, seen): (Option<&AzimuthSensor>, Option<&[SeenView]>),
    spec: &EstimatorSpec,
) -> Result<Answer, StageError> {
    let ideal = ideal.map(|sensor| sensor as &dyn ObservationModel);
    let process = match &method.model.process {
        Some((fitted, _)) if method.row.has_process() => {
            Some(ResidualProcess::new(method.model.viewing(), fitted).map_err(ModelRefusal::Answer)?)
        }
        _ => None,
    };
    let process = process.as_ref().map(|process| process as &dyn ObservationModel);
    let processes = processes_of(method)?;
    let processes = processes.as_ref().map(|tried| tried.each_ref().map(|of| of as &dyn ObservationModel));
    let layer = layer_of(method)?;
    let layer = layer.as_ref().map(|layer| layer as &dyn LastLayer);
    let reader = Reader { ideal, process, processes, layer, seen, ..method.model.reader() };
    let estimator = method.row.estimator(&spec.settings(), reader);
    match catch_unwind(AssertUnwindSafe(|| estimator.estimate(observations))) {
        Ok(Ok(estimate)) => {
            let mut answer = Answer::new(estimate);
            if method.row.frames_are_free() {
                answer.objects.iter_mut().flatten().for_each(StoredObject::forget_frame);
            }
            if method.row.has_process() {
                // The process's own numbers are of no latent that a model knows.
                let own = method.model.model.manifest().latent.dimension;
                answer.objects.iter_mut().flatten().for_each(|object| object.keep_latent(own));
            }
            if method.row.reads_truth() {
                // It is of no model.
                answer.objects.iter_mut().flatten().for_each(|object| object.latent = None);
            }
            Ok(answer)
        }
        Ok(Err(error @ EstimateError::Model(_))) => Ok(Answer::failed(error.to_string())),
        Ok(Err(error)) => Err(error.into()),
        Err(_) => Ok(Answer::failed(PANICKED.to_owned())),
    }
}
