//! The line that data walks, stage by stage: views -> model, episodes -> estimates -> scores.
//!
//! Every stage is an entry of the cache, by the hash of all that can change it, so that a second run of a scene
//! simulates, trains and estimates nothing.

mod associating;
mod associations;
mod associator_row;
mod azimuth_sensor;
mod beliefs;
mod cells;
mod embedding;
mod episodes;
mod error;
mod estimates;
mod found;
#[cfg(feature = "train")]
mod held_out;
#[cfg(feature = "train")]
mod known_views;
mod model;
mod model_error;
mod object_process;
mod online;
mod readouts;
mod stage_cache;
#[cfg(feature = "train")]
mod study;
mod tables;
mod taken_for;
#[cfg(feature = "train")]
mod training;
mod true_views;
mod unseen;
#[cfg(feature = "train")]
mod variant_views;
mod views;

use crate::code;

pub use associations::{
    Associated, GIVEN, SeedAssociations, association_rows, association_table, associations,
};
pub use azimuth_sensor::AzimuthSensor;
pub use cells::{Cell, CellRuns, Pass, cell, row_names};
pub use embedding::embedding;
pub use episodes::{EpisodeFolder, SeedEpisode, TRUE_MOTION, concerns_one_seed, episodes, recorded_caveat};
pub use error::StageError;
pub use estimates::{Answer, Lessons, Method, PANICKED, SeedAnswers, StoredObject, estimates, methods};
#[cfg(feature = "train")]
pub use known_views::Teller;
pub use model::{
    LoadedModel, Naming, any_model, beside_or_supplied, caveat, check_unseen, chosen_model, chosen_models,
    model, model_hash, models, reference_model,
};
pub use model_error::ModelRefusal;
pub use online::{OnlineAnswer, OnlineRun, SeedOnline, online};
#[cfg(feature = "train")]
pub use study::{
    ImportedViews, StudyViews, VariantModel, VariantModels, finished_model, study_views, variant_models,
    variant_scores,
};
pub use tables::{Tables, online_table, tables};
#[cfg(feature = "train")]
pub use training::{train, train_on};
pub use true_views::true_viewpoint;
pub use unseen::{ScoredViews, embedded, imported_views, test_views, unseen};
pub use vantage_sim::render::choice::RendererChoice;
pub use views::{VIEW_CONDITIONS, views};

use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use stage_cache::StageCache;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use vantage_sim::checked::CheckedScene;
use vantage_sim::render::choice::{Opened, open};
use vantage_sim::render::{Renderer, RendererInfo};

/// A scene on its way through the stages.
pub struct Pipeline {
    /// The scene as read.
    pub file: SceneFile,
    /// Folder of the scene file: paths in it are relative to this.
    pub folder: PathBuf,
    /// Folder of the model that it names; `None` where it names none.
    pub reference: Option<PathBuf>,
    /// Its simulated part.
    pub scene: CheckedScene,
    /// Hash of the whole scene.
    pub scene_hash: String,
    /// What renders.
    pub renderer_info: RendererInfo,
    /// Where progress is shown.
    pub progress: Progress,
    renderer: RefCell<Box<dyn Renderer>>,
    cache: StageCache,
}

impl Pipeline {
    /// Reads and checks the scene, and opens the cache and the renderer.
    pub fn open(path: &Path, cache: &Path, choice: RendererChoice) -> Result<Self, StageError> {
        Self::of(scene_file::read(path)?, path, cache, choice, Progress::detect())
    }

    /// Likewise, of a scene that was read from `path`, and may have been changed since.
    pub fn of(
        file: SceneFile,
        path: &Path,
        cache: &Path,
        choice: RendererChoice,
        progress: Progress,
    ) -> Result<Self, StageError> {
        if file.evaluation.episodes.is_some() && (file.robot.path.stations() || !file.vary.is_empty()) {
            return Err(StageError::NotRecordable);
        }
        let scene = file.checked(path, cache, &progress)?;
        let Opened { renderer, notice } = open(choice)?;
        if let Some(notice) = notice {
            progress.note(&notice);
        }
        let reference = reference_model(&file, path, cache)?;
        let cache = StageCache::open(cache, &progress)?;
        Ok(Self {
            scene_hash: scene_file::hash(&file)?,
            folder: path.parent().unwrap_or(Path::new(".")).to_owned(),
            reference,
            file,
            scene,
            renderer_info: renderer.info(),
            renderer: RefCell::new(renderer),
            progress,
            cache,
        })
    }

    /// The folder of episodes that take the place of simulated ones, if the scene names one.
    pub fn recorded(&self) -> Option<PathBuf> {
        self.file.evaluation.episodes.as_ref().map(|episodes| self.folder.join(episodes))
    }

    /// Whether a robot drives: in a scene of stations only single views are scored.
    pub fn drives(&self) -> bool {
        !self.file.robot.path.stations()
    }
}
