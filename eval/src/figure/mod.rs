//! Figures: SVG without fonts of its own, and PNG.

pub mod contact_sheet;
pub mod likelihood;
pub mod scene_sheet;
pub mod trajectory;

use plotters::style::RGBColor;
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

/// Colours that the colour-blind tell apart (Okabe and Ito), without the black that is the truth's.
const PALETTE: [RGBColor; 7] = [
    RGBColor(230, 159, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(148, 128, 0),
];

fn color(index: usize) -> RGBColor {
    PALETTE[index % PALETTE.len()]
}
