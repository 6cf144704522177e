//! Everything that ends a run of `bench` early.

use super::dataset::error::DatasetError;
use super::import::error::ImportRefusal;
use super::look::error::LookError;
use super::scene::error::RunError;
use super::source::SourceError;
use super::validation::error::ValidationError;
use crate::figure::FigureError;
#[cfg(feature = "rerun")]
use crate::figure::recording::RecordingError;
use crate::gate::GateError;
use crate::left_out::LeftOut;
use crate::pipeline::StageError;
use crate::result::error::SaveError;
use crate::result::output_folder::OutputError;
use crate::result::results_file::ResultsError;
use crate::result::standing::FullerResult;
use crate::result::table::TableError;
use crate::result::trajectory::TrajectoryError;
use crate::scene_file::SceneFileError;
use crate::scene_file::study::VariantError;
use crate::score::entry::EntryError;
use crate::score::pairs::PairsError;
use std::path::PathBuf;
use thiserror::Error;
use vantage_dataset::store::StoreError;
use vantage_formats::ImportError;
use vantage_model::AnswerError;
use vantage_sim::error::SimError;
use vantage_sim::render::RenderError;

/// Everything that ends a run early.
#[derive(Debug, Error)]
pub enum BenchError {
    /// See [`SceneFileError`].
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// See [`SourceError`].
    #[error(transparent)]
    Source(#[from] SourceError),
    /// See [`FullerResult`].
    #[error(transparent)]
    FullerResult(#[from] FullerResult),
    /// See [`StageError`].
    #[error(transparent)]
    Stage(#[from] StageError),
    /// See [`SaveError`].
    #[error(transparent)]
    Save(#[from] SaveError),
    /// See [`OutputError`].
    #[error(transparent)]
    Output(#[from] OutputError),
    /// See [`StoreError`].
    #[error(transparent)]
    Store(#[from] StoreError),
    /// See [`SimError`].
    #[error(transparent)]
    Sim(#[from] SimError),
    /// See [`RenderError`].
    #[error(transparent)]
    Render(#[from] RenderError),
    /// See [`vantage_learn::ModelError`].
    #[error(transparent)]
    Model(#[from] vantage_learn::ModelError),
    /// Model folders that are refused, of those to be told of.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Refused(Vec<vantage_learn::ModelError>),
    /// See [`AnswerError`].
    #[error("observation model: {0}")]
    Answer(#[from] AnswerError),
    /// See [`FigureError`].
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// See [`EntryError`].
    #[error(transparent)]
    Entry(#[from] EntryError),
    /// See [`RunError`].
    #[error(transparent)]
    Run(#[from] RunError),
    /// See [`ResultsError`].
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// See [`GateError`].
    #[error(transparent)]
    Gate(#[from] GateError),
    /// See [`DatasetError`].
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// See [`ImportError`].
    #[error(transparent)]
    Import(#[from] ImportError),
    /// See [`ImportRefusal`].
    #[error(transparent)]
    ImportRefused(#[from] ImportRefusal),
    /// See [`LookError`].
    #[error(transparent)]
    Look(#[from] LookError),
    /// See [`RecordingError`].
    #[cfg(feature = "rerun")]
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// See [`ValidationError`].
    #[error(transparent)]
    Validation(#[from] ValidationError),
    /// See [`VariantError`].
    #[error(transparent)]
    Variant(#[from] VariantError),
    /// A folder that is to be read is not there.
    #[error("there is no folder {}", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder that a dataset was to be written to holds something else.
    #[error(
        "{} already holds something else: nothing was changed; choose a new or empty folder with --out",
        folder.display()
    )]
    NotOurs {
        /// The folder.
        folder: PathBuf,
    },
    /// See [`LeftOut`].
    #[error(transparent)]
    LeftOut(#[from] LeftOut),
    /// An estimator answered with poses that cannot be scored.
    #[error("an estimate cannot be scored: {0}")]
    Pairs(#[from] PairsError),
    /// An estimator answered with poses that are no trajectory.
    #[error("an estimate is no trajectory: {0}")]
    Trajectory(#[from] TrajectoryError),
    /// See [`TableError`].
    #[error(transparent)]
    Table(#[from] TableError),
    /// Standard output is closed or full.
    #[error("cannot write to standard output: {0}")]
    Stdout(#[from] std::io::Error),
    /// A value of ours that JSON cannot hold.
    #[error("cannot write as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A table that CSV cannot hold.
    #[error("cannot write as CSV: {0}")]
    Csv(#[from] csv::Error),
}
