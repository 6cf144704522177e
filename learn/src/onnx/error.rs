//! What can be wrong with an ONNX file.

use super::OPSETS;

/// Why an ONNX file is refused, or its run failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum GraphError {
    /// Not a protobuf of the ONNX schema, or cut short.
    #[error("not an ONNX model, or cut short ({bytes} bytes): {reason}")]
    Malformed { bytes: usize, reason: String },
    /// Another operator set.
    #[error(
        "operator sets {got}, expected the default domain alone in one of {OPSETS:?}; export with opset 17"
    )]
    Opset { got: String },
    /// A feature of ONNX that no model needs here.
    #[error("{what} is not supported; export plain nodes with their weights in the file")]
    Unsupported { what: String },
    /// Weights outside the file.
    #[error(
        "weight {tensor:?} lies in an external file, which is never read; save the model with its weights inside"
    )]
    ExternalData { tensor: String },
    /// An operator in a form of which one processor makes other bits than another.
    #[error("node {node:?} is {form}, whose bits would depend on the processor; {remedy}")]
    ProcessorDependent { node: String, form: &'static str, remedy: &'static str },
    /// An operator outside the list.
    #[error("node {node:?} uses operator {operator:?}, expected one of {expected:?}")]
    Operator {
        node: String,
        /// Its operator, with its domain where it is not the default one.
        operator: String,
        expected: &'static [&'static str],
    },
    /// Nodes that do not hang together.
    #[error("tensor {tensor:?} {fault}")]
    Wiring { tensor: String, fault: &'static str },
    /// Inputs or outputs other than expected.
    #[error("{side} are {got}, expected {expected}")]
    Signature { side: &'static str, got: String, expected: String },
    /// A weight whose data does not fill its shape.
    #[error("weight {tensor:?} of shape {shape:?} holds {got} bytes, expected {expected}")]
    WeightSize { tensor: String, shape: Vec<i64>, got: usize, expected: usize },
    /// A weight that is NaN or infinite.
    #[error("weight {tensor:?} is {value} at {index}; the training diverged or the file is damaged")]
    NonFiniteWeight { tensor: String, index: usize, value: f32 },
    /// More nodes and weights than any network of crops needs.
    #[error(
        "the graph has {nodes} nodes and weights, at most {limit} are expected; simplify it before the export"
    )]
    Nodes { nodes: usize, limit: usize },
    /// A node whose operands or attributes do not fit its operator.
    #[error("node {:?} ({}): {} is {}, expected {}", .0.node, .0.operator, .0.what, .0.got, .0.expected)]
    Node(Box<NodeFault>),
    /// Nodes whose operands are all weights, and that take and make too many numbers.
    #[error(
        "node {node:?} ({operator}) depends on no input, and up to it the nodes of weights alone take and make more than \
         {limit} numbers; compute it before the export"
    )]
    Stored { node: String, operator: String, limit: usize },
    /// A tensor between two nodes that is far larger than any crop's network needs.
    #[error("node {node:?} makes a tensor of shape {shape}, at most {limit} numbers are expected")]
    TensorSize { node: String, shape: String, limit: usize },
    /// The runtime does not take the graph.
    #[error("tract refuses the graph: {reason}")]
    Refused { reason: String },
    /// An input of the wrong length.
    #[error("input {input:?} has {got} numbers, expected {expected}")]
    Input { input: String, got: usize, expected: usize },
    /// An input that is NaN, infinite or absurdly large.
    #[error("input {input:?} is not finite, or beyond 1e6; drop the measurement")]
    InputRange { input: String },
    /// An output that is NaN or infinite.
    #[error("output {output:?} is not finite; drop the measurement")]
    NonFiniteOutput { output: String },
}

/// What does not fit at a node.
#[derive(Debug)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub struct NodeFault {
    pub node: String,
    pub operator: String,
    pub what: String,
    pub got: String,
    pub expected: String,
}
