//! Why a scene is not drawn.

use crate::exit::Ends;
use std::path::PathBuf;
use thiserror::Error;

/// Why a scene is not drawn.
#[derive(Debug, Error)]
pub enum LookError {
    /// A picture that would not be one.
    #[error("--out {}: expected the name of a PNG file", path.display())]
    NoPicture { path: PathBuf },
}

impl Ends for LookError {}
