//! Why a run that was scored still counts for nothing.

use crate::exit::{Ends, Exit};
use std::path::PathBuf;
use thiserror::Error;

/// Why a run that was scored still counts for nothing.
#[derive(Debug, Error)]
pub enum RunError {
    /// A row panicked.
    #[error("an estimator panicked on {}: its runs count as failed, all others were written", scene.display())]
    Panicked { scene: PathBuf },
    /// Asked for with a scene that stands for many cells.
    #[error(
        "{} varies fields of its own, and {what} is of one cell: leave out `vary` of the scene, or {what}", scene.display()
    )]
    Varies { scene: PathBuf, what: &'static str },
    /// Asked for with a scene of single views.
    #[error("{}: no robot drives in this scene; leave {what} out", scene.display())]
    Undriven { scene: PathBuf, what: &'static str },
    /// Asked for with a setting that takes whole episodes.
    #[error(
        "{}: `estimator.unknown_margin` asks all views of an object, and `--online` has but those so far: leave one of them out", scene.display()
    )]
    WholeEpisodes { scene: PathBuf },
    /// Every row failed on every seed.
    #[error(
        "every estimator failed on every seed of {}: the tables that were written say why", scene.display()
    )]
    NothingAnswered { scene: PathBuf },
    /// A row of which no run succeeded.
    #[error("no run of {method} succeeded on {}: {reason}; all else was written", scene.display())]
    NothingOf {
        method: String,
        scene: PathBuf,
        /// Why the first failed.
        reason: String,
    },
    /// No object was detected in any episode.
    #[error(
        "no object was detected in any episode of {}: tables were written, but only dead reckoning was scored; turn \
         the camera (`robot.camera`), move the path, or lower `sensors.detector`", scene.display()
    )]
    NothingSeen { scene: PathBuf },
}

impl Ends for RunError {
    fn exit(&self) -> Exit {
        match self {
            Self::Panicked { .. } => Exit::Bug,
            Self::Varies { .. } | Self::Undriven { .. } | Self::WholeEpisodes { .. } => Exit::BadInput,
            Self::NothingAnswered { .. } | Self::NothingOf { .. } | Self::NothingSeen { .. } => {
                Exit::NothingEvaluated
            }
        }
    }
}
