//! The shape of every tensor of a graph, node by node, before any runtime sees it.
//!
//! Operands, attributes and sizes are checked on the way, and so is how much a graph makes and multiplies: what comes out of here is
//! a graph that a runtime can take, in a time and memory that are bounded.

mod layout;
mod node;
mod pointwise;
mod product;
mod rows;
mod tensor;
#[cfg(test)]
mod tests;
mod window;

use super::error::GraphError;
use super::{Signature, TensorSpec};
use node::Node;
use pointwise::MOST_OPERANDS;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use tensor::{Tensor, volume};
use tract_onnx::pb::GraphProto;
use tract_onnx::pb::tensor_proto::DataType;

/// Numbers of the largest tensor within a graph: 64 MiB of `f32`.
const LARGEST_TENSOR: usize = 16 << 20;
/// Numbers that the nodes of weights alone may take and make together: enough to widen all of the largest file from 16 bits.
const MOST_STORED: usize = 256 << 20;
/// Numbers that all nodes may make together, since a runtime may have to hold them all: 1 GiB of `f32`.
const MOST_MADE: usize = 256 << 20;
/// Products that a run may take: a minute's work at worst, and a hundred times what a large network does to a crop.
const MOST_PRODUCTS: usize = 1 << 36;

/// How many operands an operator takes, and what it makes of them.
type Operation = (&'static str, RangeInclusive<usize>, fn(&Node) -> Result<Vec<Tensor>, GraphError>);

const OPERATIONS: [Operation; 54] = [
    ("Abs", 1..=1, pointwise::single),
    ("Add", 2..=2, pointwise::pair),
    ("AveragePool", 1..=1, window::pool),
    ("BatchNormalization", 5..=5, rows::batch_normalization),
    ("Cast", 1..=1, layout::cast),
    ("Clip", 1..=3, pointwise::clip),
    ("Concat", 1..=MOST_OPERANDS, layout::concat),
    ("Constant", 0..=0, layout::constant),
    ("Conv", 2..=3, window::conv),
    ("ConvTranspose", 2..=3, window::conv_transpose),
    ("Cos", 1..=1, pointwise::single),
    ("Div", 2..=2, pointwise::pair),
    ("Elu", 1..=1, pointwise::single),
    ("Erf", 1..=1, pointwise::single),
    ("Exp", 1..=1, pointwise::single),
    ("Flatten", 1..=1, layout::flatten),
    ("Gather", 2..=2, layout::gather),
    ("Gemm", 2..=3, product::gemm),
    ("GlobalAveragePool", 1..=1, window::global_pool),
    ("GlobalMaxPool", 1..=1, window::global_pool),
    ("HardSigmoid", 1..=1, pointwise::single),
    ("HardSwish", 1..=1, pointwise::single),
    ("Identity", 1..=1, layout::identity),
    ("InstanceNormalization", 3..=3, rows::instance_normalization),
    ("LayerNormalization", 2..=3, rows::layer_normalization),
    ("LeakyRelu", 1..=1, pointwise::single),
    ("Log", 1..=1, pointwise::single),
    ("MatMul", 2..=2, product::matmul),
    ("Max", 1..=MOST_OPERANDS, pointwise::several),
    ("MaxPool", 1..=1, window::pool),
    ("Min", 1..=MOST_OPERANDS, pointwise::several),
    ("Mul", 2..=2, pointwise::pair),
    ("Neg", 1..=1, pointwise::single),
    ("PRelu", 2..=2, pointwise::prelu),
    ("Pad", 2..=4, layout::pad),
    ("Pow", 2..=2, pointwise::pair),
    ("Reciprocal", 1..=1, pointwise::single),
    ("ReduceMean", 1..=2, rows::reduce),
    ("ReduceSum", 1..=2, rows::reduce),
    ("Relu", 1..=1, pointwise::single),
    ("Reshape", 2..=2, layout::reshape),
    ("Sigmoid", 1..=1, pointwise::single),
    ("Sign", 1..=1, pointwise::single),
    ("Sin", 1..=1, pointwise::single),
    ("Slice", 3..=5, layout::slice),
    ("Softmax", 1..=1, rows::softmax),
    ("Softplus", 1..=1, pointwise::single),
    ("Split", 1..=2, layout::split),
    ("Sqrt", 1..=1, pointwise::single),
    ("Squeeze", 1..=2, layout::squeeze),
    ("Sub", 2..=2, pointwise::pair),
    ("Tanh", 1..=1, pointwise::single),
    ("Transpose", 1..=1, layout::transpose),
    ("Unsqueeze", 2..=2, layout::unsqueeze),
];

/// Operators a model may use: those of feed-forward networks. None repeats, loops or draws at random, and of each the shape of what
/// it makes is known before a run.
pub const OPERATORS: [&str; OPERATIONS.len()] = {
    let mut names = [""; OPERATIONS.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = OPERATIONS[index].0;
        index += 1;
    }
    names
};

/// Checks all nodes of a graph whose weights, inputs and names are checked.
pub(super) fn check_shapes(graph: &GraphProto, opset: i64, signature: &Signature) -> Result<(), GraphError> {
    let input = |spec: &TensorSpec| (spec.name.clone(), Tensor::new(DataType::Float, spec.shape.clone()));
    let mut known: BTreeMap<String, Tensor> = signature.inputs.iter().map(input).collect();
    known.extend(graph.initializer.iter().map(|weight| (weight.name.clone(), Tensor::weight(weight))));
    let mut spent = Spent::default();
    for proto in &graph.node {
        let operand =
            |name: &String| Some(name).filter(|name| !name.is_empty()).and_then(|name| known.get(name));
        let node = Node::new(proto, opset, proto.input.iter().map(operand).collect())?;
        let mut results = results(&node)?;
        if proto.output.len() != results.len() || proto.output.iter().any(String::is_empty) {
            let got = proto.output.iter().filter(|name| !name.is_empty()).count();
            return Err(node.fault("the number of results", got, results.len()));
        }
        spent.add(&node, &results)?;
        let stored = node.operands().all(|operand| operand.stored);
        results.iter_mut().for_each(|result| result.stored = stored);
        known.extend(proto.output.iter().cloned().zip(results));
    }
    Ok(())
}

/// What a node makes.
fn results(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let operation = OPERATIONS.iter().find(|(name, ..)| *name == node.operator());
    let (_, operands, made) =
        operation.ok_or_else(|| node.fault("the operator", "unknown", "a known one"))?;
    node.takes(operands)?;
    made(node)
}

/// What the nodes so far take to compute.
#[derive(Default)]
struct Spent {
    /// Numbers taken and made by nodes of weights alone.
    stored: usize,
    made: usize,
    products: usize,
}

impl Spent {
    fn add(&mut self, node: &Node, results: &[Tensor]) -> Result<(), GraphError> {
        let operator = || node.operator().to_owned();
        let too_large = |result: &&Tensor| result.volume() > LARGEST_TENSOR;
        let all = |tensors: &mut dyn Iterator<Item = &Tensor>| {
            tensors.fold(0usize, |sum, t| sum.saturating_add(t.volume()))
        };
        let (taken, made) = (all(&mut node.operands()), all(&mut results.iter()));
        if node.operands().all(|operand| operand.stored) {
            self.stored = self.stored.saturating_add(taken).saturating_add(made);
            if self.stored > MOST_STORED {
                return Err(GraphError::Stored {
                    node: node.name(),
                    operator: operator(),
                    limit: MOST_STORED,
                });
            }
        }
        if let Some(result) = results.iter().find(too_large) {
            return Err(too_large_a_tensor(node, &result.shape));
        }
        self.made = self.made.saturating_add(made);
        if self.made > MOST_MADE {
            let what = "numbers made by it and the nodes before it";
            return Err(node.fault(what, self.made, format!("at most {MOST_MADE}")));
        }
        self.products = self.products.saturating_add(products(node, made).saturating_add(taken));
        if self.products > MOST_PRODUCTS {
            let what = "products taken by it and the nodes before it";
            return Err(node.fault(what, self.products, format!("at most {MOST_PRODUCTS}")));
        }
        Ok(())
    }
}

/// Products that the numbers of a result take.
fn products(node: &Node, made: usize) -> usize {
    let shape = |index: usize| node.optional(index).map_or(&[][..], |operand| &operand.shape);
    let each = match node.operator() {
        "Conv" => volume(shape(1).get(1..).unwrap_or(&[])),
        "ConvTranspose" => {
            return volume(shape(0)).saturating_mul(volume(shape(1).get(1..).unwrap_or(&[])));
        }
        "AveragePool" | "MaxPool" => {
            let sides = node.integers("kernel_shape").unwrap_or(&[]);
            sides.iter().fold(1usize, |all, &side| all.saturating_mul(usize::try_from(side).unwrap_or(0)))
        }
        "MatMul" => shape(0).last().copied().unwrap_or(1),
        "Gemm" => {
            volume(shape(0))
                / shape(0).get(usize::from(node.integer("transA") == Some(1))).map_or(1, |&rows| rows.max(1))
        }
        _ => 1,
    };
    made.saturating_mul(each)
}

fn too_large_a_tensor(node: &Node, shape: &[usize]) -> GraphError {
    GraphError::TensorSize { node: node.name(), shape: format!("{shape:?}"), limit: LARGEST_TENSOR }
}
