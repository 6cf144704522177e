//! Inputs with the outputs the trainer computed: the proof that a model folder runs here as it did there.

use crate::manifest::Role;
use serde::{Deserialize, Serialize};

/// The canary's file.
pub const CANARY: &str = "canary.json";

/// Largest difference of an output to the trainer's, relative to `1 + |output|`.
pub const TOLERANCE: f32 = 1e-4;

/// Runs of the graphs, and what must come out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Canary {
    /// Largest difference allowed, relative to `1 + |output|`.
    pub tolerance: f32,
    /// The runs.
    pub cases: Vec<CanaryCase>,
}

/// One run of one graph, tensors row-major in the order of the graph's signature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CanaryCase {
    /// The graph.
    pub role: Role,
    /// What goes in.
    pub inputs: Vec<Vec<f32>>,
    /// What the trainer computed.
    pub outputs: Vec<Vec<f32>>,
}

/// The largest difference of `got` to `expected`, relative to `1 + |expected|`; infinite where lengths differ
/// or a number is not finite.
pub(crate) fn deviation(got: &[f32], expected: &[f32]) -> f32 {
    if got.len() != expected.len() {
        return f32::INFINITY;
    }
    got.iter().zip(expected).fold(0.0, |worst: f32, (got, expected)| {
        let difference = (got - expected).abs() / (1.0 + expected.abs());
        if difference.is_finite() { worst.max(difference) } else { f32::INFINITY }
    })
}
