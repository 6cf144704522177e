//! Why settings cannot be tried on a scene.

use crate::exit::{Ends, Exit};
use std::path::PathBuf;
use thiserror::Error;

/// Why settings cannot be tried on a scene.
#[derive(Debug, Error)]
pub enum ValidationError {
    /// There is no trajectory to score.
    #[error("no robot drives in {}: name a scene whose robot follows a path", scene.display())]
    Undriven { scene: PathBuf },
    /// No object was detected in any episode.
    #[error(
        "no object was detected in any episode of {}: turn the camera (`robot.camera`), move the path, or lower \
         `sensors.detector`", scene.display()
    )]
    NothingSeen { scene: PathBuf },
}

impl Ends for ValidationError {
    fn exit(&self) -> Exit {
        match self {
            Self::Undriven { .. } => Exit::BadInput,
            Self::NothingSeen { .. } => Exit::NothingEvaluated,
        }
    }
}
