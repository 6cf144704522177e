//! ONNX graphs: read with suspicion, checked, and run by tract; written node by node.

#[cfg(feature = "train")]
pub(crate) mod build;
pub(crate) mod check;
mod contained;
pub(crate) mod error;
pub(crate) mod graph;
mod infer;
#[cfg(target_arch = "x86_64")]
mod kernels;
pub(crate) mod last_layer;
mod memory;
#[cfg(target_arch = "x86_64")]
mod routines;

pub use infer::OPERATORS;
use std::ops::RangeInclusive;

/// Operator sets of the files read.
pub const OPSETS: RangeInclusive<i64> = 13..=18;

/// A tensor of a graph's signature: always `f32`, always of fixed shape.
#[derive(Clone, Debug, PartialEq, Eq)]
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// Inputs.
    pub inputs: Vec<TensorSpec>,
    /// Outputs.
    pub outputs: Vec<TensorSpec>,
}
