//! Inputs with the outputs their maker computed: the proof that a model folder runs here as it did there.

use crate::error::ModelError;
use crate::onnx::error::GraphError;
use crate::onnx::graph::Graph;
use crate::role::Role;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file that the trainer writes it to.
pub const CANARY: &str = "canary.json";

/// Largest difference of an output to the maker's, relative to `1 + |output|`.
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
    /// What its maker computed.
    pub outputs: Vec<Vec<f32>>,
}

impl Canary {
    /// The canary in the bytes of `path`.
    pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, ModelError> {
        let canary: Self = serde_json::from_slice(bytes)
            .map_err(|source| ModelError::Json { path: path.to_owned(), source })?;
        if (0.0..=TOLERANCE).contains(&canary.tolerance) {
            return Ok(canary);
        }
        Err(ModelError::Manifest {
            path: path.to_owned(),
            field: "tolerance".into(),
            got: canary.tolerance.to_string(),
            expected: format!("0 to {TOLERANCE}"),
        })
    }
}

impl CanaryCase {
    /// The output that differs most, and by how much.
    pub(crate) fn worst(&self, graph: &Graph) -> Result<Option<(String, f32)>, GraphError> {
        let inputs: Vec<_> = self.inputs.iter().map(Vec::as_slice).collect();
        let outputs = graph.run(&inputs)?;
        let deviations = graph.signature().outputs.iter().enumerate().map(|(index, spec)| {
            let expected = self.outputs.get(index);
            let got = expected.map_or(f32::INFINITY, |expected| deviation(&outputs[index], expected));
            (spec.name.clone(), got)
        });
        Ok(deviations.max_by(|(_, a), (_, b)| a.total_cmp(b)))
    }
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
