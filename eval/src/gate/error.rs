//! Why nothing can be compared.

use crate::exit::{Ends, Exit};
use thiserror::Error;

/// Why fresh results cannot be compared with a baseline.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GateError {
    /// The baseline is of another scene file.
    #[error(
        "the baseline was made from another state of the scene {scene} (hash {baseline}, now {fresh}): run `bench` on \
         it again with `--out results` and commit what it writes"
    )]
    Scene {
        /// The scene.
        scene: String,
        /// The baseline's hash.
        baseline: String,
        /// The fresh hash.
        fresh: String,
    },
    /// The baseline has no such seed.
    #[error(
        "table {table}: the baseline has no run on seed {seed}: compare on seeds that it has, those of the scene file \
         or some of them"
    )]
    Seed {
        /// The table.
        table: String,
        /// The seed.
        seed: u64,
    },
    /// The baseline has no number at all.
    #[error("the baseline holds no number: nothing was compared")]
    Nothing,
}

impl Ends for GateError {
    fn exit(&self) -> Exit {
        match self {
            Self::Scene { .. } | Self::Seed { .. } => Exit::BadInput,
            Self::Nothing => Exit::NothingEvaluated,
        }
    }
}
