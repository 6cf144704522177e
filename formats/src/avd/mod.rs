//! The Active Vision dataset: homes, photographed from a grid of points in twelve headings each.
//!
//! ```text
//! <scan>/jpg_rgb/<13 digits>01.jpg
//! <scan>/high_res_depth/<13 digits>03.png   16 bits, registered to colour, millimetres, 0 = missing
//! <scan>/annotations.json                   boxes, and where each movement leads
//! <scan>/image_structs.mat                  poses by COLMAP, and the scale
//! <scan>/cameras.txt                        intrinsics by COLMAP
//! <scan>/present_instance_names.txt
//! instance_id_map.txt
//! ```
//!
//! `x_camera = R x_world + t`; `scale` takes the reconstruction's units to millimetres; the world's y axis is vertical.

mod annotations;
mod boxes;
mod camera;
mod export;
mod grid;
mod images;
mod import;
mod labels;
mod movement;
mod movement_graph;
mod name;
mod objects;
mod views;

pub use export::AvdWriter;
pub(crate) use import::odometry;
pub use import::{AvdScan, ODOMETRY_ROTATION_SIGMA, ODOMETRY_TRANSLATION_SIGMA, read_scan};
pub use labels::ID_MAPS;
pub use movement::Movement;
pub use movement_graph::MovementGraph;
pub use name::{ScanName, SceneType};

/// Headings at a point of the grid, 30 degrees apart.
pub const HEADINGS: u32 = 12;
/// Between points of the grid, metres.
pub const GRID: f64 = 0.3;
