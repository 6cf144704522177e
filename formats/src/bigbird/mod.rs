//! BigBIRD: objects on a turntable, seen by five cameras at 120 angles.
//!
//! ```text
//! <object>/NP{c}_{a}.jpg               image of camera c = 1..=5 at a degrees
//! <object>/NP{c}_{a}.h5                /depth, u16, 0.1 mm, 0 = missing
//! <object>/masks/NP{c}_{a}_mask.pbm    the object is black, which decodes to 0
//! <object>/calibration.h5              NP{c}_rgb_K, NP{c}_rgb_d, H_NP{c}_from_NP5 ...
//! <object>/poses/NP5_{a}_pose.h5       H_table_from_reference_camera
//! <object>/poses/turntable.h5          center, normal
//! ```
//!
//! A camera's pose in the table's frame, which turns with the object, is
//! `H_table_from_reference_camera * inverse(H_NP{c}_from_NP5)`.

mod calibration;
mod export;
mod import;
mod name;
mod silhouette;
mod table;

pub use export::BigBirdWriter;
pub use import::{is_object, object_folders, read_objects, uncalibrated_folders};

/// Cameras of the rig.
pub const CAMERAS: usize = 5;
/// The camera that poses are given of.
pub const REFERENCE: usize = 5;
/// File of an object's folder, without which its images have no camera.
const CALIBRATION: &str = "calibration.h5";
/// OpenCV, which calibrated the rig, puts the centre of the first pixel at 0; here it is at 0.5.
const PIXEL_CENTER: f64 = 0.5;
