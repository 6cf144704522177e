//! The commands of `bench` that run the line.

mod baseline;
mod check;
pub mod cli;
mod dataset;
pub mod end;
mod error;
mod figures;
mod folder;
pub mod help;
mod import;
mod index;
pub mod interrupt;
mod list;
mod look;
mod map;
mod models;
mod needs;
pub mod no_display;
mod places;
mod report;
pub mod run;
mod scene;
mod score;
mod shell;
pub mod source;
#[cfg(feature = "train")]
mod study;
mod study_pages;
mod sweep;
mod task;
#[cfg(feature = "train")]
mod train;
mod validation;
#[cfg(feature = "train")]
mod view_split;

pub use baseline::baseline;
pub use check::check;
pub use dataset::dataset;
pub use figures::figures;
pub use import::import;
pub use index::{INDEX, folders, index, pages, scene_table, scenes, write_index};
pub use list::list;
pub use look::look;
pub use map::{MAP_FILE, map, map_pages};
pub use models::models;
pub use report::{REPORT, report};
pub use scene::bench;
pub use score::score;
pub use shell::{completions, man};
#[cfg(feature = "train")]
pub use study::study;
pub use study_pages::{STUDY_FILE, study_pages};
pub use sweep::sweep;
pub use task::task;
#[cfg(feature = "train")]
pub use train::train;
pub use validation::{calibrate, headroom};

use crate::scene_file::misfit;
use error::BenchError;
use std::path::Path;
use vantage_sim::error::SimError;

/// What a simulation says, with the place in the scene file where one has to be changed.
fn placed(error: SimError, scene: &Path) -> BenchError {
    misfit(&error, scene).map_or_else(|| error.into(), BenchError::from)
}
