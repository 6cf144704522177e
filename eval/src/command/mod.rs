//! The commands of `bench` that run the line.

mod check;
mod dataset;
mod figures;
mod import;
mod look;
mod models;
mod pictures;
mod score;
#[cfg(feature = "train")]
mod study;
mod tables;
#[cfg(feature = "train")]
mod train;

pub use check::check;
pub use dataset::dataset;
pub use figures::figures;
pub use import::import;
pub use look::look;
pub use models::models;
pub use score::bench;
#[cfg(feature = "train")]
pub use study::study;
#[cfg(feature = "train")]
pub use train::train;
