//! Why nothing can be compared.

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
    /// The baseline has other seeds.
    #[error(
        "table {table} has {fresh} seeds and the baseline {baseline}, or others: compare with the seeds of the scene file"
    )]
    Seeds {
        /// The table.
        table: String,
        /// Seeds of the baseline.
        baseline: usize,
        /// Fresh seeds.
        fresh: usize,
    },
    /// The baseline has no number at all.
    #[error("the baseline holds no number: nothing was compared")]
    Nothing,
}
