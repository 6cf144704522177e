//! Why a figure was not drawn.

use crate::exit::{Ends, Exit};
use thiserror::Error;

/// Why a figure was not drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FigureError {
    /// Nothing to draw.
    #[error("the {figure} figure has nothing to show")]
    Empty {
        /// Which figure.
        figure: &'static str,
    },
    /// A number that is NaN or infinite.
    #[error("the {figure} figure has a number that is not finite in {of}")]
    NotFinite {
        /// Which figure.
        figure: &'static str,
        /// In which of its series.
        of: String,
    },
    /// The drawing library refused.
    #[error("the {figure} figure cannot be drawn: {reason}")]
    Draw {
        /// Which figure.
        figure: &'static str,
        /// What it said.
        reason: String,
    },
}

impl Ends for FigureError {
    fn exit(&self) -> Exit {
        Exit::Bug
    }
}
