//! Why a model folder is refused.

use crate::manifest::Role;
pub use crate::onnx::error::GraphError;
use std::path::PathBuf;

/// Why a model folder cannot be loaded, or a loaded model not be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A file is not there or cannot be read.
    #[error(
        "cannot read {path:?}: {source}; a model folder holds model.json, canary.json and five .onnx files"
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file larger than any model of this kind.
    #[error("{path:?} has {bytes} bytes, at most {limit} are read")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// A JSON file that does not parse, or lacks or exceeds its fields.
    #[error("{path:?}: {source}")]
    Json {
        /// The file.
        path: PathBuf,
        /// Line, column and field.
        source: serde_json::Error,
    },
    /// Another format, or another version of it.
    #[error("{path:?} is {got:?}, expected {expected:?}; train the model anew")]
    Version {
        /// The manifest.
        path: PathBuf,
        /// Format and version found.
        got: String,
        /// Format and version read here.
        expected: String,
    },
    /// A manifest that contradicts itself or this program.
    #[error("{path:?}: {field} is {got}, expected {expected}")]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// The field.
        field: String,
        /// What it says.
        got: String,
        /// What it should say.
        expected: String,
    },
    /// A graph that is refused.
    #[error("{path:?}: {source}")]
    Graph {
        /// The file.
        path: PathBuf,
        /// Why.
        source: GraphError,
    },
    /// A file other than the one the manifest was written for.
    #[error("{path:?} has BLAKE3 {got}, the manifest says {expected}; the folder was mixed or damaged")]
    Hash {
        /// The file.
        path: PathBuf,
        /// Hash of its bytes.
        got: String,
        /// Hash in the manifest.
        expected: String,
    },
    /// A graph that computes something else than it did where it was trained.
    #[error(
        "{path:?}: output {output:?} differs from the trainer's by {got:e}, at most {tolerance:e} is allowed"
    )]
    Canary {
        /// The graph's file.
        path: PathBuf,
        /// The output.
        output: String,
        /// Largest difference, relative to `1 + |output|`.
        got: f32,
        /// The limit.
        tolerance: f32,
    },
    /// A run of a loaded model that failed.
    #[error("{role:?}: {source}")]
    Run {
        /// The graph.
        role: Role,
        /// Why.
        source: GraphError,
    },
}
