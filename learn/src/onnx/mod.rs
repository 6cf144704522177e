//! ONNX graphs: read with suspicion, checked, and run by tract; written node by node.

#[cfg(feature = "train")]
pub(crate) mod build;
pub(crate) mod check;
pub(crate) mod error;
pub(crate) mod graph;

use serde::{Deserialize, Serialize};

/// Operator set of the files written and read.
pub const OPSET: i64 = 17;

/// Operators a model may use: what the trainer writes.
pub const OPERATORS: [&str; 13] = [
    "Add", "Clip", "Concat", "Conv", "Flatten", "Gemm", "MatMul", "Mul", "Relu", "Reshape", "Sigmoid",
    "Split", "Sub",
];

/// A tensor of a graph's signature: always `f32`, always of fixed shape.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TensorSpec {
    /// Its name in the graph.
    pub name: String,
    /// Its shape, batch of 1 first.
    pub shape: Vec<usize>,
}

impl TensorSpec {
    /// A tensor of a name and shape.
    pub fn new(name: &str, shape: &[usize]) -> Self {
        Self { name: name.to_owned(), shape: shape.to_vec() }
    }

    /// Numbers in the tensor.
    pub fn volume(&self) -> usize {
        self.shape.iter().product()
    }
}

/// What goes into a graph and comes out of it, in order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signature {
    /// Inputs.
    pub inputs: Vec<TensorSpec>,
    /// Outputs.
    pub outputs: Vec<TensorSpec>,
}
