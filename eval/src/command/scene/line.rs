//! The line of `bench SCENE`: scene -> sim -> dataset -> learn -> slam -> eval -> results.

use super::error::RunError;
use super::record::Record;
use crate::command::cli::StageArgs;
use crate::command::error::BenchError;
use crate::command::placed;
use crate::command::sweep::Part;
use crate::pipeline::{
    LoadedModel, Method, Naming, Pipeline, ScoredViews, SeedAnswers, SeedAssociations, SeedEpisode,
    SeedOnline, StageError, association_rows, association_table, associations, chosen_models, episodes,
    estimates, methods, models, online, online_table, tables, test_views, unseen,
};
use crate::result::manifest::Manifest;
use crate::result::results_file::Results;
use crate::scene_file::SceneFile;
use crate::scene_file::row::Row;
use crate::scene_file::row_name::{kind_names, reserved_names};
use crate::score::association_entry::AssociationEntry;
use crate::score::entry::Entry;
use crate::score::unseen::{Subject, Unseen};
use std::path::{Path, PathBuf};
use vantage_dataset::store::read_truth;
use vantage_dataset::{Seed, Split};
use vantage_sim::world::check_room;

/// What a line does beside estimating whole episodes with association given.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beside<'a> {
    /// Estimates also after every step.
    pub online: bool,
    /// Asks who is who.
    pub associate: bool,
    /// Folders of other associators' answers to that.
    pub associations: &'a [PathBuf],
    /// The share of the seeds that it takes.
    pub part: Part,
}

/// Runs the line on a scene.
pub fn line(
    scene: &Path,
    stages: &StageArgs,
    naming: Naming,
    beside: Beside<'_>,
) -> Result<Scored, BenchError> {
    let pipeline = Pipeline::open(scene, &stages.making.cache, stages.making.renderer.into())?;
    if beside.associate && !pipeline.drives() {
        return Err(RunError::Undriven { scene: scene.to_owned(), what: "`--associate`" }.into());
    }
    if beside.online && !pipeline.drives() {
        return Err(RunError::Undriven { scene: scene.to_owned(), what: "`--online`" }.into());
    }
    if beside.online && pipeline.file.estimator.unknown_margin.is_some() {
        return Err(RunError::WholeEpisodes { scene: scene.to_owned() }.into());
    }
    let seeds = beside.part.of(seeds(&pipeline.file, stages));
    if pipeline.recorded().is_none() && beside.part == Part::default() {
        has_room(&pipeline, &seeds, scene)?;
    }
    let entries = entries(&pipeline, stages, &seeds)?;
    let associated = associated(&pipeline, beside.associations, &seeds)?;
    let chosen = chosen_models(&pipeline, stages.train, &stages.model)?;
    let mut record = Record::begin(&pipeline, &seeds, stages)?;

    // What a model makes of simulated objects says nothing of recorded ones.
    let views = match pipeline.recorded() {
        Some(_) => Vec::new(),
        None => record.timed("test views", || test_views(&pipeline, &seeds))?,
    };
    let models = record.timed("model", || {
        let others: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        // That of the scene has no name but what it is.
        let naming = if stages.model.is_empty() { Naming::Kind } else { naming };
        let models = models(&pipeline, &chosen, naming, &others)?;
        let unseen = |model: &LoadedModel| views.iter().try_for_each(|views| model.check_set(&views.set));
        models.iter().try_for_each(unseen)?;
        Ok::<_, StageError>(models)
    })?;
    let methods = methods(&pipeline.file.estimator.rows, &models);
    let (episodes, answers) = drive(&pipeline, &seeds, &models, &methods, &mut record)?;
    let online = match beside.online {
        true => record.timed("online", || online(&pipeline, &episodes, &methods))?,
        false => Vec::new(),
    };
    let associations = match (beside.associate || !associated.is_empty()) && pipeline.drives() {
        true => record.timed("associations", || associations(&pipeline, &episodes, &methods, &associated))?,
        false => Vec::new(),
    };
    let unseen = record.timed("unseen instances", || {
        let of_model = |model: &LoadedModel| {
            unseen(&pipeline, &views, Subject::Viewing(model.viewing()), model.model.hash())
        };
        models.iter().map(of_model).collect::<Result<Vec<_>, _>>()
    })?;
    let mut tables = tables(&seeds, &methods, &entries, &episodes, &answers, &models, &unseen)?;
    tables.tables.extend(online_table(&seeds, &methods, &episodes, &answers, &online)?);
    tables.tables.extend(association_table(&seeds, &associated, &associations)?);

    Ok(Scored {
        results: Results::new(&pipeline.file.name, &pipeline.scene_hash, tables.tables),
        detections: tables.detections,
        recorded: pipeline.recorded().is_some(),
        methods: methods.iter().map(Method::name).collect(),
        rows: pipeline.file.estimator.rows.clone(),
        manifest: record.finish(&pipeline, &models, (&entries, &associated), &episodes, &views)?,
        episodes,
        answers,
        online,
        association_rows: association_rows(&associated),
        associations,
        associated,
        entries,
        unseen: models.iter().map(|model| model.name.clone()).zip(unseen).collect(),
        models,
        views,
    })
}

/// Episodes of objects that no model has seen, and every method's answers; none where no robot drives.
fn drive(
    pipeline: &Pipeline,
    seeds: &[Seed],
    models: &[LoadedModel],
    methods: &[Method<'_>],
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
            let truth = read_truth(&episode.folder)?;
            let instances = || truth.objects.iter().map(|object| object.instance);
            models.iter().try_for_each(|model| model.check_unseen(instances()))?;
        }
        estimates(pipeline, &episodes, methods)
    })?;
    Ok((episodes, answers))
}

/// Refuses a scene whose objects find room under none of the seeds, before anything is rendered for it.
fn has_room(pipeline: &Pipeline, seeds: &[Seed], scene: &Path) -> Result<(), BenchError> {
    let mut refused = None;
    for seed in seeds.iter().filter(|_| pipeline.drives()) {
        match check_room(&pipeline.scene, Split::Test, *seed) {
            Ok(()) => return Ok(()),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    refused.map_or(Ok(()), |error| Err(placed(error, scene)))
}

/// Trajectories of other estimators that are scored beside ours.
fn entries(pipeline: &Pipeline, stages: &StageArgs, seeds: &[Seed]) -> Result<Vec<Entry>, BenchError> {
    match stages.trajectories.first() {
        Some(folder) if !pipeline.drives() => Err(Entry::undriven(folder).into()),
        _ => {
            let taken: Vec<String> = reserved_names().into_iter().chain(kind_names()).collect();
            Ok(Entry::open(&stages.trajectories, &taken, seeds, &pipeline.progress)?)
        }
    }
}

/// Associations of others that are scored beside ours.
fn associated(
    pipeline: &Pipeline,
    folders: &[PathBuf],
    seeds: &[Seed],
) -> Result<Vec<AssociationEntry>, BenchError> {
    match folders.first() {
        Some(folder) if !pipeline.drives() => Err(AssociationEntry::undriven(folder).into()),
        _ => Ok(AssociationEntry::open(folders, &association_rows(&[]), seeds)?),
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
    /// The methods' names, in the order of the answers.
    pub methods: Vec<String>,
    /// Of the scene: each is a method, or one a model.
    pub rows: Vec<Row>,
    /// The methods' answers by seed.
    pub answers: Vec<SeedAnswers>,
    /// Their answers after every step by seed; empty where not asked for.
    pub online: Vec<SeedOnline>,
    /// The rows of associations.
    pub association_rows: Vec<String>,
    /// Their answers by seed; empty where not asked for.
    pub associations: Vec<SeedAssociations>,
    /// Estimators of others.
    pub entries: Vec<Entry>,
    /// Other associators.
    pub associated: Vec<AssociationEntry>,
    /// Each model's name and its scores on unseen instances, one a seed.
    pub unseen: Vec<(String, Vec<Unseen>)>,
    /// Detections of objects in all episodes.
    pub detections: usize,
    /// The models.
    pub models: Vec<LoadedModel>,
    /// The views of instances that they are scored on, one set a seed; none of recorded episodes.
    pub views: Vec<ScoredViews>,
    /// Whether the episodes were recorded, of images that may not be shown.
    pub recorded: bool,
}

/// A model's likelihood against the azimuth's offset, mean over the seeds that have one; empty without any.
pub fn mean_likelihood(unseen: &[Unseen]) -> Vec<(f64, f64)> {
    let curves: Vec<_> = unseen.iter().filter(|seed| !seed.likelihood.is_empty()).collect();
    let Some(first) = curves.first() else { return Vec::new() };
    let mean = |i: usize| curves.iter().map(|seed| seed.likelihood[i].1).sum::<f64>() / curves.len() as f64;
    first.likelihood.iter().enumerate().map(|(i, (offset, _))| (*offset, mean(i))).collect()
}
