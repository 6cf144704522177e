//! Figures: SVG without fonts of its own, and PNG.

pub mod calibration;
pub mod canvas;
pub mod crop_table;
pub mod embedding_map;
mod error;
pub mod gains;
pub mod law;
pub mod likelihood;
pub mod map;
pub mod nees;
pub mod online;
pub mod palette;
#[cfg(feature = "rerun")]
pub mod recording;
pub mod scene_sheet;
mod svg;
pub mod trajectory;
pub mod tsne;
pub mod viewpoint_map;

pub use error::FigureError;
