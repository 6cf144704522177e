//! Why a stage of the line has no answer.

use super::model_error::ModelRefusal;
use crate::exit::{Ends, Exit};
use crate::left_out::LeftOut;
use crate::result::output_folder::OutputError;
use crate::result::table::TableError;
use crate::scene_file::SceneFileError;
use crate::scene_file::study::VariantError;
use crate::score::association_entry::AssociationEntryError;
use crate::score::pairs::PairsError;
use std::path::PathBuf;
use thiserror::Error;
use vantage_dataset::store::StoreError;
use vantage_model::AnswerError;
use vantage_sim::error::SimError;
use vantage_sim::render::RenderError;
use vantage_slam::EstimateError;

/// Why a stage of the line has no answer.
#[derive(Debug, Error)]
pub enum StageError {
    /// See [`SceneFileError`].
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// See [`RenderError`].
    #[error(transparent)]
    Render(#[from] RenderError),
    /// See [`SimError`].
    #[error(transparent)]
    Sim(#[from] SimError),
    /// See [`StoreError`].
    #[error(transparent)]
    Store(#[from] StoreError),
    /// See [`OutputError`].
    #[error(transparent)]
    Output(#[from] OutputError),
    /// See [`vantage_learn::ModelError`].
    #[error(transparent)]
    Model(#[from] vantage_learn::ModelError),
    /// See [`AnswerError`].
    #[error("observation model: {0}")]
    Answer(#[from] AnswerError),
    /// See [`ModelRefusal`].
    #[error(transparent)]
    Refused(#[from] ModelRefusal),
    /// See [`LeftOut`].
    #[error(transparent)]
    LeftOut(#[from] LeftOut),
    /// See [`vantage_learn::TrainError`].
    #[cfg(feature = "train")]
    #[error(transparent)]
    Train(#[from] vantage_learn::TrainError),
    /// A stored view set is not there.
    #[error("there is no folder {}, which {named_by} names; `bench import` writes one", folder.display())]
    NoViews {
        /// The setting or the option.
        named_by: String,
        /// The folder.
        folder: PathBuf,
    },
    /// A folder of recorded episodes is not there.
    #[error(
        "there is no folder {}, which the scene's evaluation.episodes names; write it with `bench import`, or leave the field out",
        folder.display()
    )]
    NoEpisodes {
        /// The folder.
        folder: PathBuf,
    },
    /// An episode of a seed was not recorded.
    #[error("there is no folder {}: ask for fewer seeds, those that were written", folder.display())]
    NoEpisode {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder of recorded episodes holds another thing.
    #[error("{} is no episode of the seed that it is named after: leave it as `bench import` wrote it", folder.display())]
    OtherEpisode {
        /// The folder.
        folder: PathBuf,
    },
    /// A recorded robot that estimators would take for level, and that is not.
    #[error(
        "{}: truth/robot.tum: the robot's z axis is {degrees:.1} degrees off the world's at the first step, where estimators take it for level and {limit:.0} is the most; \
         import it again, or give the robot a level frame and `robot_from_camera` the tilt",
        folder.display()
    )]
    TiltedRobot {
        /// The episode's folder.
        folder: PathBuf,
        /// Between the robot's z axis and the world's.
        degrees: f64,
        /// The most that is let pass.
        limit: f64,
    },
    /// Recorded episodes of a scene in which no robot drives, or that varies.
    #[error(
        "evaluation.episodes is for a scene in which a robot drives and nothing varies: leave it out, or copy the scene"
    )]
    NotRecordable,
    /// See [`AssociationEntryError`].
    #[error(transparent)]
    Associations(#[from] AssociationEntryError),
    /// See [`EstimateError`].
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// Scores that are no numbers, which are not cached.
    #[error(
        "the model's scores on unseen instances of seed {seed} are not all finite numbers: check its outputs and its residual"
    )]
    NotFinite {
        /// The seed of the instances.
        seed: u64,
    },
    /// A cached answer is not what was written.
    #[error("{}: {reason}; remove the cache entry and run again", path.display())]
    StoredAnswers {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// See [`VariantError`].
    #[error(transparent)]
    Variant(#[from] VariantError),
    /// A study of known instances whose sessions are too short.
    #[error(
        "scored: known holds out every fourth view of a session, but of instance {instance} no session has four: raise \
         views.views_per_instance of the study's scene, or lower views.sessions"
    )]
    NothingHeldOut {
        /// Its place among the training instances.
        instance: usize,
    },
    /// An estimator answered with poses that cannot be scored.
    #[error("an estimate cannot be scored: {0}")]
    Pairs(#[from] PairsError),
    /// The pipeline handed over runs that make no table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A value of ours that JSON cannot hold.
    #[error("cannot write as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl Ends for StageError {
    fn exit(&self) -> Exit {
        match self {
            Self::Scene(error) => error.exit(),
            Self::Render(error) => error.exit(),
            Self::Sim(error) => error.exit(),
            Self::Store(error) => error.exit(),
            Self::Output(error) => error.exit(),
            Self::Model(error) => error.exit(),
            Self::Answer(error) => error.exit(),
            Self::Refused(error) => error.exit(),
            Self::LeftOut(error) => error.exit(),
            #[cfg(feature = "train")]
            Self::Train(error) => error.exit(),
            Self::Associations(error) => error.exit(),
            Self::Estimate(error) => error.exit(),
            Self::Variant(error) => error.exit(),
            Self::Pairs(error) => error.exit(),
            Self::Table(error) => error.exit(),
            Self::Json(error) => error.exit(),
            Self::NoViews { .. }
            | Self::NoEpisodes { .. }
            | Self::NoEpisode { .. }
            | Self::OtherEpisode { .. }
            | Self::TiltedRobot { .. }
            | Self::NotRecordable
            | Self::NothingHeldOut { .. } => Exit::BadInput,
            Self::NotFinite { .. } | Self::StoredAnswers { .. } => Exit::StoredDataInvalid,
        }
    }
}
