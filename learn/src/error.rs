//! Why a model folder is refused.

pub use crate::onnx::error::{GraphError, NodeFault};
use crate::role::Role;
use std::path::PathBuf;

/// Why a model folder cannot be loaded, or a loaded model not be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ModelError {
    /// A file is not there or cannot be read.
    #[error(
        "cannot read {path:?}: {source}; a model folder holds model.yaml and the files it names, see docs/models.md"
    )]
    Read { path: PathBuf, source: std::io::Error },
    /// A file larger than any model of this kind.
    #[error("{path:?} has more than the {limit} bytes that are read of a file")]
    TooLarge { path: PathBuf, limit: u64 },
    /// Something other than a file, such as a device.
    #[error("{path:?} is not a file")]
    NotAFile { path: PathBuf },
    /// A manifest that does not parse, or lacks or exceeds its fields.
    #[error("{path:?} is not valid:\n{message}")]
    Yaml { path: PathBuf, message: String },
    /// A canary that does not parse, or lacks or exceeds its fields.
    #[error("{path:?}: {source}")]
    Json { path: PathBuf, source: serde_json::Error },
    /// Another format, or another version of it.
    #[error("{path:?} is {got:?}, expected {expected:?}; see docs/models.md")]
    Version { path: PathBuf, got: String, expected: String },
    /// A manifest that contradicts itself or this program.
    #[error("{path:?}: {field} is {got}, expected {expected}")]
    Manifest { path: PathBuf, field: String, got: String, expected: String },
    /// A graph that is refused.
    #[error("{path:?}: {source}")]
    Graph { path: PathBuf, source: GraphError },
    /// A file other than the one the manifest was written for.
    #[error("{path:?} has SHA-256 {got}, the manifest says {expected}; the folder was mixed or damaged")]
    Hash {
        path: PathBuf,
        /// Hash of its bytes.
        got: String,
        expected: String,
    },
    /// A graph that computes something else than it did where it was made.
    #[error(
        "{path:?}: output {output:?} differs from its maker's by {got:e}, at most {tolerance:e} is allowed"
    )]
    Canary {
        path: PathBuf,
        output: String,
        /// Largest difference, relative to `1 + |output|`.
        got: f32,
        tolerance: f32,
    },
    /// A Jacobian that is not that of the graph it belongs to.
    #[error(
        "{path:?}: output {output:?} is not what {of} and its central differences give: {got:.2} of their size away on the canary's \
         inputs, expected at most {limit}; look at signs, scales and the order of rows and columns"
    )]
    Derivatives {
        path: PathBuf,
        output: String,
        of: Role,
        /// Distance, relative (Frobenius norms).
        got: f64,
        limit: f64,
    },
    /// A graph that a model of its kind may have, and this one has not.
    #[error("the model has no graph {role}")]
    Absent { role: Role },
    /// A crop without a viewpoint, for an encoder that is told it.
    #[error("the encoder of a viewpoint-dependent model needs the crop's viewpoint")]
    NoViewpoint,
    /// A run of a loaded model that failed.
    #[error("{role}: {source}")]
    Run { role: Role, source: GraphError },
}
