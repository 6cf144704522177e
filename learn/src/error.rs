//! Why a model folder is refused.

pub use crate::onnx::error::{GraphError, NodeFault};
use crate::role::{Kind, Role};
use std::path::PathBuf;

/// Why a model folder cannot be loaded, or a loaded model not be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A file is not there or cannot be read.
    #[error(
        "cannot read {path:?}: {source}; a model folder holds model.yaml and the files it names, see docs/models.md"
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file larger than any model of this kind.
    #[error("{path:?} has more than the {limit} bytes that are read of a file")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit.
        limit: u64,
    },
    /// Something other than a file, such as a device.
    #[error("{path:?} is not a file")]
    NotAFile {
        /// Its path.
        path: PathBuf,
    },
    /// A manifest that does not parse, or lacks or exceeds its fields.
    #[error("{path:?} is not valid:\n{message}")]
    Yaml {
        /// The manifest.
        path: PathBuf,
        /// Line, column and field.
        message: String,
    },
    /// A canary that does not parse, or lacks or exceeds its fields.
    #[error("{path:?}: {source}")]
    Json {
        /// The file.
        path: PathBuf,
        /// Line, column and field.
        source: serde_json::Error,
    },
    /// Another format, or another version of it.
    #[error("{path:?} is {got:?}, expected {expected:?}; see docs/models.md")]
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
    #[error("{path:?} has SHA-256 {got}, the manifest says {expected}; the folder was mixed or damaged")]
    Hash {
        /// The file.
        path: PathBuf,
        /// Hash of its bytes.
        got: String,
        /// Hash in the manifest.
        expected: String,
    },
    /// A graph that computes something else than it did where it was made.
    #[error(
        "{path:?}: output {output:?} differs from its maker's by {got:e}, at most {tolerance:e} is allowed"
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
    /// A Jacobian that is not that of the graph it belongs to.
    #[error(
        "{path:?}: output {output:?} is not what {of} and its central differences give: {got:.2} of their size away on the canary's \
         inputs, expected at most {limit}; look at signs, scales and the order of rows and columns"
    )]
    Derivatives {
        /// The Jacobian's file.
        path: PathBuf,
        /// The output.
        output: String,
        /// The graph that was differentiated.
        of: Role,
        /// Distance, relative (Frobenius norms).
        got: f64,
        /// The limit.
        limit: f64,
    },
    /// A model of a kind that a use has nothing to do with.
    #[error("{path:?} is a model of kind {got}, expected one of kind {expected}")]
    Kind {
        /// The manifest.
        path: PathBuf,
        /// Its kind.
        got: Kind,
        /// The kind that is needed.
        expected: Kind,
    },
    /// A graph that a model of its kind may have, and this one has not.
    #[error("the model has no graph {role}")]
    Absent {
        /// The graph.
        role: Role,
    },
    /// A crop without a viewpoint, for an encoder that is told it.
    #[error("the encoder of a viewpoint-dependent model needs the crop's viewpoint")]
    NoViewpoint,
    /// A run of a loaded model that failed.
    #[error("{role}: {source}")]
    Run {
        /// The graph.
        role: Role,
        /// Why.
        source: GraphError,
    },
}
