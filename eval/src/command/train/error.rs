//! Why nothing is trained.

use crate::exit::{Ends, Exit};
use thiserror::Error;

/// A GPU was asked of a program that was built without.
#[derive(Debug, Error)]
#[error(
    "this program was built without GPUs: build it with `cargo build --release -p vantage-eval --features gpu`, or leave \
     --gpu out"
)]
pub struct NoGpuBuild;

impl Ends for NoGpuBuild {
    fn exit(&self) -> Exit {
        Exit::MissingCapability
    }
}
