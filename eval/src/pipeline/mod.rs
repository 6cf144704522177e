//! The line that data walks, stage by stage: views -> model, episodes -> estimates -> scores.
//!
//! Every stage is an entry of the cache, by the hash of all that can change it, so that a second run of a scene
//! simulates, trains and estimates nothing.

mod code;
mod episodes;
mod estimates;
mod model;
#[cfg(feature = "train")]
mod study;
mod tables;
#[cfg(feature = "train")]
mod training;
mod unseen;
mod views;

pub use code::SIMULATED;
pub use episodes::{EpisodeFolder, SeedEpisode, concerns_one_seed, episodes};
pub use estimates::{Answer, Method, PANICKED, SeedAnswers, StoredObject, estimates, methods};
pub use model::{
    LoadedModel, Naming, any_model, caveat, check_unseen, chosen_model, model, model_hash, models,
};
#[cfg(feature = "train")]
pub use study::{
    StudyViews, VariantModel, VariantModels, finished_model, study_views, variant_models, variant_scores,
};
pub use tables::{Tables, tables};
#[cfg(feature = "train")]
pub use training::{train, train_on};
pub use unseen::{ScoredViews, imported_views, test_views, unseen};
pub use vantage_sim::render::choice::RendererChoice;
pub use views::{VIEW_CONDITIONS, views};

use crate::error::BenchError;
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::Duration;
use vantage_dataset::store::{Cache, Entry, Key, Origin};
use vantage_sim::checked::CheckedScene;
use vantage_sim::render::choice::{Opened, open};
use vantage_sim::render::{Renderer, RendererInfo};

/// Work of a killed run that nobody took up is removed after this time.
const ABANDONED_AFTER: Duration = Duration::from_secs(7 * 24 * 3600);

/// A scene on its way through the stages.
pub struct Pipeline {
    /// The scene as read.
    pub file: SceneFile,
    /// Folder of the scene file: paths in it are relative to this.
    pub folder: PathBuf,
    /// Its simulated part.
    pub scene: CheckedScene,
    /// Hash of the whole scene.
    pub scene_hash: String,
    /// What renders.
    pub renderer_info: RendererInfo,
    /// Where progress is shown.
    pub progress: Progress,
    renderer: RefCell<Box<dyn Renderer>>,
    cache: Cache,
}

impl Pipeline {
    /// Reads and checks the scene, and opens the cache and the renderer.
    pub fn open(path: &Path, cache: &Path, choice: RendererChoice) -> Result<Self, BenchError> {
        let file: SceneFile = scene_file::read(path)?;
        let progress = Progress::detect();
        let scene = file.checked(path, &progress)?;
        let Opened { renderer, notice } = open(choice)?;
        if let Some(notice) = notice {
            progress.note(&notice);
        }
        let waiting = progress.clone();
        let cache = Cache::open(cache)?.on_wait(move |holder| waiting.note(&holder.to_string()));
        cache.remove_abandoned_work(ABANDONED_AFTER)?;
        Ok(Self {
            scene_hash: scene_file::hash(&file)?,
            folder: path.parent().unwrap_or(Path::new(".")).to_owned(),
            file,
            scene,
            renderer_info: renderer.info(),
            renderer: RefCell::new(renderer),
            progress,
            cache,
        })
    }

    /// Whether a robot drives: in a scene of stations only single views are scored.
    pub fn drives(&self) -> bool {
        !self.file.robot.path.stations()
    }

    fn stored(
        &self,
        key: &Key,
        build: impl FnOnce(&Path) -> Result<(), BenchError>,
    ) -> Result<Entry, BenchError> {
        stored(&self.cache, &self.progress, key, build)
    }
}

/// The entry of a key, built where the cache has none; a damaged one is set aside and told of.
fn stored(
    cache: &Cache,
    progress: &Progress,
    key: &Key,
    build: impl FnOnce(&Path) -> Result<(), BenchError>,
) -> Result<Entry, BenchError> {
    let entry = cache.get_or_build(key, build)?;
    if let Origin::Rebuilt { damage, quarantined } = &entry.origin {
        progress.note(&format!(
            "warning: the cached {} was damaged ({damage}); it was moved to {} and made anew",
            key.stage(),
            quarantined.display()
        ));
    }
    Ok(entry)
}
