//! Datasets in the layouts of others.
//!
//! | layout | import | export |
//! |---|---|---|
//! | BigBIRD (Singh et al. 2014): objects on a turntable | [`bigbird::read_objects`] | [`bigbird::BigBirdWriter`] |
//! | Active Vision (Ammirato et al. 2017): homes, in a grid of images | [`avd::read_scan`] | [`avd::AvdWriter`] |
//!
//! See `docs/import.md`.

pub mod avd;
pub mod bigbird;
mod hdf5;
mod import;
mod lens;
pub mod mat5;
mod picture;
mod ray;

pub use import::{ImportError, ImportReport, Problem, Skipped};
pub use lens::Lens;

use crate::ObjectTruth;

/// The name of a simulated object in an exported dataset: its family and the 16 hexadecimal digits of its id.
pub fn object_name(object: &ObjectTruth) -> String {
    format!("{}_{:016x}", object.family, object.instance.0)
}
