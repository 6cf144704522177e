//! Everything that ends a run of `bench` early.

use super::baseline::BaselineError;
use super::dataset::error::DatasetError;
use super::folder::FolderError;
use super::import::error::ImportRefusal;
use super::look::error::LookError;
use super::models::error::Refused;
use super::report::error::ReportError;
use super::scene::error::RunError;
use super::score::error::ScoreError;
use super::source::error::SourceError;
use super::sweep::error::SweepError;
use super::task::error::TaskError;
use super::validation::error::ValidationError;
use crate::exit::{Ends, Exit};
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
use crate::scene_file::vary::VaryError;
use crate::score::association_entry::AssociationEntryError;
use crate::score::entry::EntryError;
use crate::score::pairs::PairsError;
use thiserror::Error;
use vantage_dataset::store::StoreError;
use vantage_formats::ImportError;
use vantage_learn::ModelError;
use vantage_model::AnswerError;
use vantage_sim::error::SimError;
use vantage_sim::render::RenderError;

/// Declares [`BenchError`] of the errors it may be, each with what is said before it, if anything.
macro_rules! errors {
    ($($(#[$built:meta])* $name:ident($error:ty) $said:literal;)*) => {
        /// Everything that ends a run early, in its own words.
        #[derive(Debug, Error)]
        pub enum BenchError {
            $(
                $(#[$built])*
                #[doc = concat!("`", stringify!($error), "`.")]
                #[error($said)]
                $name(#[from] $error),
            )*
        }

        impl Ends for BenchError {
            fn exit(&self) -> Exit {
                match self {
                    $($(#[$built])* Self::$name(error) => error.exit(),)*
                }
            }
        }
    };
}

errors! {
    Scene(SceneFileError) "{0}";
    Source(SourceError) "{0}";
    Folder(FolderError) "{0}";
    FullerResult(FullerResult) "{0}";
    Stage(StageError) "{0}";
    Save(SaveError) "{0}";
    Output(OutputError) "{0}";
    Store(StoreError) "{0}";
    Sim(SimError) "{0}";
    Render(RenderError) "{0}";
    Model(ModelError) "{0}";
    Refused(Refused) "{0}";
    Score(ScoreError) "{0}";
    Answer(AnswerError) "observation model: {0}";
    Figure(FigureError) "{0}";
    Entry(EntryError) "{0}";
    AssociationEntry(AssociationEntryError) "{0}";
    Run(RunError) "{0}";
    Results(ResultsError) "{0}";
    Gate(GateError) "{0}";
    Dataset(DatasetError) "{0}";
    Import(ImportError) "{0}";
    ImportRefused(ImportRefusal) "{0}";
    Baseline(BaselineError) "{0}";
    Sweep(SweepError) "{0}";
    Task(TaskError) "{0}";
    Look(LookError) "{0}";
    Report(ReportError) "{0}";
    #[cfg(feature = "rerun")]
    Recording(RecordingError) "{0}";
    LeftOut(LeftOut) "{0}";
    Validation(ValidationError) "{0}";
    Variant(VariantError) "{0}";
    Vary(VaryError) "{0}";
    Pairs(PairsError) "an estimate cannot be scored: {0}";
    Trajectory(TrajectoryError) "an estimate is no trajectory: {0}";
    Table(TableError) "{0}";
    Stdout(std::io::Error) "cannot write to standard output: {0}";
    Json(serde_json::Error) "cannot write as JSON: {0}";
    Csv(csv::Error) "cannot write as CSV: {0}";
}
