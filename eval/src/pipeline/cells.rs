//! A cell of a map: one scene's episodes, and the trajectories of all that runs in it.

use super::associating::Associating;
use super::estimates::{Lessons, drives};
use super::found::found as found_by;
use super::tables::trajectory_runs;
use super::{
    LoadedModel, Naming, Pipeline, SeedEpisode, StageError, chosen_model, episodes, methods, models,
};
use crate::progress::Progress;
use crate::result::metric::Metric;
use crate::result::run::Run;
use crate::scene_file::SceneFile;
use crate::scene_file::associator::AssociatedBy;
use crate::scene_file::life::drive_seed;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vantage_dataset::store::read_truth;
use vantage_dataset::{Seed, Split};
use vantage_sim::render::RendererInfo;
use vantage_sim::render::choice::RendererChoice;

/// What runs in a cell: rows that read crops by one model.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The cell's scene, with the rows and their settings. World, robot and sensors are those of all passes of a cell.
    pub scene: SceneFile,
    /// Folder of the model; `None` for the scene's own.
    pub model: Option<PathBuf>,
    /// Who tells which object a detection is of; `None` where the episode does.
    pub association: Option<AssociatedBy>,
}

/// What a cell is made of.
pub struct Cell<'a> {
    /// What runs, at least one.
    pub passes: &'a [Pass],
    /// The file that the scene was read from.
    pub path: &'a Path,
    /// Folder of the cache.
    pub cache: &'a Path,
    /// What renders.
    pub renderer: RendererChoice,
    /// Its seeds.
    pub seeds: &'a [Seed],
    /// Which drive of the lives with these seeds it is.
    pub drive: Option<u64>,
    /// What is scored.
    pub columns: &'a [Metric],
    /// Where it tells of itself.
    pub progress: &'a Progress,
}

/// What came out of a cell.
pub struct CellRuns {
    /// The rows, in the order of the estimates.
    pub methods: Vec<String>,
    /// Every row's run on every seed.
    pub runs: Vec<Run>,
    /// The hash of each model, by its folder's name.
    pub models: BTreeMap<String, String>,
    /// The seals of its episodes.
    pub seals: Vec<String>,
    /// What each row that learns knows after it.
    pub lessons: Lessons,
    /// What rendered.
    pub renderer: RendererInfo,
}

/// The rows of a pass, by name; nothing is simulated for that.
pub fn row_names(cell: &Cell<'_>, pass: &Pass) -> Result<Vec<String>, StageError> {
    let progress = cell.progress.clone();
    let pipeline = Pipeline::of(pass.scene.clone(), cell.path, cell.cache, cell.renderer, progress)?;
    let models = models_of(&pipeline, pass.model.as_deref())?;
    Ok(methods(&pipeline.file.estimator.rows, &models).iter().map(super::Method::name).collect())
}

fn models_of(pipeline: &Pipeline, model: Option<&Path>) -> Result<Vec<LoadedModel>, StageError> {
    let chosen = chosen_model(pipeline, false, model)?;
    models(pipeline, &[chosen], Naming::Kind, &[])
}

/// Simulates, estimates and scores a cell after those that taught `before`, or takes from the cache what is there.
pub fn cell(cell: &Cell<'_>, before: &Lessons) -> Result<CellRuns, StageError> {
    let mut made: Option<CellRuns> = None;
    for pass in cell.passes {
        let progress = cell.progress.clone();
        let pipeline = Pipeline::of(pass.scene.clone(), cell.path, cell.cache, cell.renderer, progress)?;
        let more = runs(&pipeline, pass, cell, before)?;
        match &mut made {
            None => made = Some(more),
            Some(made) => {
                made.methods.extend(more.methods);
                made.runs.extend(more.runs);
                made.models.extend(more.models);
                made.lessons.extend(more.lessons);
            }
        }
    }
    Ok(made.expect("something runs in every cell"))
}

fn runs(
    pipeline: &Pipeline,
    pass: &Pass,
    &Cell { seeds, drive, columns, .. }: &Cell<'_>,
    before: &Lessons,
) -> Result<CellRuns, StageError> {
    let models = models_of(pipeline, pass.model.as_deref())?;
    let methods = methods(&pipeline.file.estimator.rows, &models);
    let of_drive: Vec<Seed> =
        seeds.iter().map(|&seed| drive.map_or(seed, |drive| drive_seed(seed, drive))).collect();
    let made = episodes(pipeline, &of_drive, Split::Test)?;
    let of_life = |(&seed, (_, episode)): (&Seed, SeedEpisode)| (seed, episode);
    let episodes: Vec<SeedEpisode> = seeds.iter().zip(made).map(of_life).collect();
    let associating = pass.association.map(|_| Associating::new(pipeline, &models[0])).transpose()?;
    let mut seals = Vec::new();
    for episode in episodes.iter().filter_map(|(_, episode)| episode.as_ref().ok()) {
        let truth = read_truth(&episode.folder)?;
        let instances = || truth.objects.iter().map(|object| object.instance);
        models.iter().try_for_each(|model| model.check_unseen(instances()))?;
        associating.iter().try_for_each(|by| by.check_unseen(instances()))?;
        seals.push(episode.seal.clone());
    }
    let found = pass.association.zip(associating.as_ref());
    let found = found
        .map(|(by, associating)| found_by(pipeline, &episodes, by, (associating, &models[0])))
        .transpose()?;
    let found = found.as_deref();
    let (answers, lessons) = drives(pipeline, &episodes, &methods, (drive.map(|_| before), found))?;
    let name = |model: &LoadedModel| {
        let folder = model.folder.file_name().unwrap_or_default();
        (folder.to_string_lossy().into_owned(), model.model.hash().to_owned())
    };
    Ok(CellRuns {
        methods: methods.iter().map(super::Method::name).collect(),
        runs: trajectory_runs(&methods, &episodes, &answers, found, columns)?,
        models: models.iter().map(name).collect(),
        seals,
        lessons,
        renderer: pipeline.renderer_info.clone(),
    })
}
