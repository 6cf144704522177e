//! Shapes of single nodes, right and wrong ones; and that a runtime takes what is let through.

#[cfg(feature = "train")]
mod taken;

use super::node::Node;
use super::tensor::{Tensor, volume};
use super::{check_shapes, results};
use crate::onnx::error::GraphError;
use crate::onnx::{OPERATORS, Signature, TensorSpec};
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{AttributeProto, GraphProto, NodeProto};

const OPSET: i64 = 17;

#[derive(Clone, Copy)]
enum Operand<'a> {
    /// Numbers of the inputs.
    X(&'a [usize]),
    /// A weight.
    W(&'a [usize]),
    /// A weight that is a list of integers.
    N(&'a [i64]),
}
use Operand::{N, W, X};

impl Operand<'_> {
    fn tensor(self) -> Tensor {
        match self {
            X(shape) => Tensor::new(DataType::Float, shape.to_vec()),
            W(shape) => Tensor { stored: true, ..Tensor::new(DataType::Float, shape.to_vec()) },
            N(list) => Tensor::of_integers(vec![list.len()], list),
        }
    }
}

/// An integer, integers, or text.
#[derive(Clone)]
enum Value {
    One(i64),
    Many(Vec<i64>),
    Text(&'static str),
}

fn attribute(name: &str, value: &Value) -> AttributeProto {
    let name = name.to_owned();
    match value {
        Value::One(i) => {
            AttributeProto { name, i: *i, r#type: AttributeType::Int as i32, ..AttributeProto::default() }
        }
        Value::Many(ints) => {
            let (r#type, ints) = (AttributeType::Ints as i32, ints.clone());
            AttributeProto { name, ints, r#type, ..AttributeProto::default() }
        }
        Value::Text(text) => {
            let (r#type, s) = (AttributeType::String as i32, text.as_bytes().to_vec());
            AttributeProto { name, s, r#type, ..AttributeProto::default() }
        }
    }
}

fn one(name: &str, value: i64) -> AttributeProto {
    attribute(name, &Value::One(value))
}

fn many(name: &str, values: &[i64]) -> AttributeProto {
    attribute(name, &Value::Many(values.to_vec()))
}

fn text(name: &str, value: &'static str) -> AttributeProto {
    attribute(name, &Value::Text(value))
}

fn made(
    operator: &str,
    attributes: Vec<AttributeProto>,
    operands: &[Operand],
) -> Result<Vec<Vec<usize>>, GraphError> {
    made_of(OPSET, operator, attributes, operands, 1)
}

fn made_of(
    opset: i64,
    operator: &str,
    attribute: Vec<AttributeProto>,
    operands: &[Operand],
    outputs: usize,
) -> Result<Vec<Vec<usize>>, GraphError> {
    let output = (0..outputs).map(|index| format!("out{index}")).collect();
    let proto = NodeProto { op_type: operator.into(), attribute, output, ..NodeProto::default() };
    let tensors: Vec<Tensor> = operands.iter().map(|operand| operand.tensor()).collect();
    let node = Node::new(&proto, opset, tensors.iter().map(Some).collect())?;
    Ok(results(&node)?.into_iter().map(|result| result.shape).collect())
}

/// Operator, attributes, operands, and what comes of them.
type Case<T> = (&'static str, Vec<AttributeProto>, &'static [Operand<'static>], T);

#[test]
fn shapes_are_those_of_the_operators() {
    const CONV: [Operand; 3] = [X(&[1, 4, 9, 9]), X(&[6, 2, 3, 3]), X(&[6])];
    let cases: Vec<Case<&[usize]>> = vec![
        ("Erf", vec![], &[X(&[64, 82])], &[64, 82]),
        ("Div", vec![], &[X(&[64, 82]), X(&[])], &[64, 82]),
        ("Mul", vec![], &[X(&[8, 1, 1, 1]), X(&[3, 3, 3])], &[8, 3, 3, 3]),
        ("Max", vec![], &[X(&[2, 1]), X(&[3]), X(&[])], &[2, 3]),
        ("PRelu", vec![], &[X(&[1, 4, 3, 3]), X(&[4, 1, 1])], &[1, 4, 3, 3]),
        ("MatMul", vec![], &[X(&[64, 82]), X(&[82])], &[64]),
        ("MatMul", vec![], &[X(&[64]), X(&[64, 82])], &[82]),
        ("MatMul", vec![], &[X(&[2, 3, 4]), X(&[4, 5])], &[2, 3, 5]),
        ("MatMul", vec![], &[X(&[7, 1, 3, 4]), X(&[2, 4, 5])], &[7, 2, 3, 5]),
        ("Gemm", vec![one("transB", 1)], &[X(&[4, 16]), X(&[8, 16]), X(&[8])], &[4, 8]),
        ("Gemm", vec![one("transA", 1)], &[X(&[16, 4]), X(&[16, 8])], &[4, 8]),
        ("Transpose", vec![many("perm", &[2, 0, 1])], &[X(&[2, 3, 4])], &[4, 2, 3]),
        ("Transpose", vec![], &[X(&[2, 3, 4])], &[4, 3, 2]),
        ("Concat", vec![one("axis", -1)], &[X(&[2, 3]), X(&[2, 5])], &[2, 8]),
        ("Flatten", vec![one("axis", -2)], &[X(&[2, 3, 4, 5])], &[6, 20]),
        ("Flatten", vec![one("axis", 3)], &[X(&[2, 3, 4])], &[24, 1]),
        ("Gather", vec![one("axis", 1)], &[X(&[7, 2]), N(&[1, -2, 0])], &[7, 3]),
        ("Reshape", vec![], &[X(&[2, 3, 4]), N(&[0, -1])], &[2, 12]),
        ("Reshape", vec![], &[X(&[1, 1]), N(&[])], &[]),
        ("Squeeze", vec![], &[X(&[1, 3, 1])], &[3]),
        ("Squeeze", vec![], &[X(&[1, 3, 1]), N(&[-1])], &[1, 3]),
        ("Unsqueeze", vec![], &[X(&[3]), N(&[0, -1])], &[1, 3, 1]),
        ("Slice", vec![], &[X(&[9, 4]), N(&[1]), N(&[i64::MAX])], &[8, 4]),
        ("Slice", vec![], &[X(&[9, 4]), N(&[-1]), N(&[i64::MIN]), N(&[0]), N(&[-2])], &[5, 4]),
        ("Slice", vec![], &[X(&[9, 4]), N(&[2, 1]), N(&[-2, 3]), N(&[0, -1]), N(&[2, 1])], &[3, 2]),
        ("Pad", vec![], &[X(&[2, 3]), N(&[0, 1, 0, 2])], &[2, 6]),
        ("ReduceSum", vec![], &[X(&[2, 3, 4]), N(&[-1, 0])], &[1, 3, 1]),
        ("ReduceSum", vec![one("noop_with_empty_axes", 1)], &[X(&[2, 3])], &[2, 3]),
        ("ReduceMean", vec![many("axes", &[1]), one("keepdims", 0)], &[X(&[2, 3, 4])], &[2, 4]),
        ("ReduceMean", vec![], &[X(&[2, 3])], &[1, 1]),
        ("LayerNormalization", vec![], &[X(&[4, 16]), X(&[16]), X(&[16])], &[4, 16]),
        ("BatchNormalization", vec![], &[X(&[1, 4, 5]), W(&[4]), W(&[4]), W(&[4]), W(&[4])], &[1, 4, 5]),
        ("InstanceNormalization", vec![], &[X(&[1, 4, 5]), X(&[4]), X(&[4])], &[1, 4, 5]),
        ("GlobalAveragePool", vec![], &[X(&[1, 4, 5, 6])], &[1, 4, 1, 1]),
        ("Conv", vec![one("group", 2)], &CONV, &[1, 6, 7, 7]),
        (
            "Conv",
            vec![one("group", 2), many("pads", &[1, 0, 2, 0]), many("strides", &[2, 3])],
            &CONV,
            &[1, 6, 5, 3],
        ),
        ("Conv", vec![one("group", 2), many("dilations", &[4, 1])], &CONV, &[1, 6, 1, 7]),
        (
            "Conv",
            vec![one("group", 2), text("auto_pad", "SAME_UPPER"), many("strides", &[2, 2])],
            &CONV,
            &[1, 6, 5, 5],
        ),
        (
            "ConvTranspose",
            vec![one("group", 2), many("strides", &[2, 2])],
            &[X(&[1, 4, 5, 5]), X(&[4, 3, 3, 3])],
            &[1, 6, 11, 11],
        ),
        (
            "ConvTranspose",
            vec![many("strides", &[2, 2]), many("pads", &[1; 4]), many("output_padding", &[1, 0])],
            &[X(&[1, 4, 5, 5]), X(&[4, 3, 3, 3])],
            &[1, 3, 10, 9],
        ),
        (
            "MaxPool",
            vec![many("kernel_shape", &[3, 3]), many("strides", &[2, 2])],
            &[X(&[1, 4, 8, 8])],
            &[1, 4, 3, 3],
        ),
        (
            "AveragePool",
            vec![many("kernel_shape", &[3, 3]), many("strides", &[2, 2]), one("ceil_mode", 1)],
            &[X(&[1, 4, 8, 8])],
            &[1, 4, 4, 4],
        ),
    ];
    for (operator, attributes, operands, expected) in cases {
        let shapes =
            made(operator, attributes, operands).unwrap_or_else(|error| panic!("{operator}: {error}"));
        assert_eq!(shapes, [expected.to_vec()], "{operator}");
    }
    let parts = made_of(OPSET, "Split", vec![one("axis", 1)], &[X(&[2, 9]), N(&[2, 7])], 2).unwrap();
    assert_eq!(parts, [[2, 2], [2, 7]]);
    assert_eq!(made_of(OPSET, "Split", vec![], &[X(&[6, 9])], 3).unwrap(), [[2, 9]; 3]);
    assert_eq!(made_of(18, "ReduceMean", vec![], &[X(&[2, 3]), N(&[1])], 1).unwrap(), [[2, 1]]);
}

#[test]
fn what_does_not_fit_is_told_with_what_was_expected() {
    const IMAGE: Operand = X(&[1, 4, 9, 9]);
    const KERNEL: Operand = X(&[6, 4, 3, 3]);
    let cases: Vec<Case<&str>> = vec![
        (
            "Transpose",
            vec![many("perm", &[0, 0, 0, 0])],
            &[IMAGE],
            "perm is [0, 0, 0, 0], expected each axis",
        ),
        ("Transpose", vec![many("perm", &[0, 1, 2])], &[IMAGE], "perm is [0, 1, 2]"),
        ("Transpose", vec![many("perm", &[0, 1, 2, -1])], &[IMAGE], "perm"),
        ("Transpose", vec![one("perm", 1)], &[IMAGE], "the type of perm is INT, expected INTS"),
        ("Flatten", vec![one("axis", 99)], &[IMAGE], "axis is 99, expected -4 to 3"),
        ("Softmax", vec![one("axis", i64::MIN)], &[IMAGE], "expected -4 to 3"),
        ("Softmax", vec![], &[X(&[])], "expected an operand with axes"),
        ("Concat", vec![one("axis", 4)], &[IMAGE, IMAGE], "axis is 4"),
        ("Concat", vec![], &[IMAGE], "axis is missing"),
        ("Concat", vec![one("axis", 1)], &[IMAGE, X(&[1, 4, 9])], "beside"),
        ("Concat", vec![one("axis", 0)], &[N(&[1]), X(&[1])], "beside"),
        ("Gather", vec![one("axis", 1)], &[IMAGE, N(&[4])], "an index is 4, expected -4 to 3"),
        ("Gather", vec![], &[IMAGE, X(&[2])], "expected a weight or Constant of integers"),
        ("Slice", vec![], &[IMAGE, N(&[0]), N(&[4]), N(&[0]), N(&[0])], "a step is 0"),
        ("Slice", vec![], &[IMAGE, N(&[0]), N(&[4]), N(&[5])], "axes is 5, expected -4 to 3"),
        ("Slice", vec![], &[IMAGE, N(&[0, 0]), N(&[4, 4]), N(&[1, -3])], "each axis once"),
        ("Slice", vec![], &[IMAGE, N(&[0]), N(&[4, 4])], "[1, 2, 1, 1]"),
        ("Slice", vec![], &[IMAGE, N(&[3]), N(&[3]), N(&[2])], "no empty side"),
        ("Squeeze", vec![], &[IMAGE, N(&[1])], "the side of axis 1 is 4, expected 1"),
        ("Squeeze", vec![], &[X(&[1, 4, 1]), N(&[-1, 0])], "axes is [2, 0], expected ascending order"),
        ("Unsqueeze", vec![], &[IMAGE, N(&[0; 99])], "99 axes"),
        ("Unsqueeze", vec![], &[IMAGE, N(&[9])], "expected -5 to 4"),
        ("Reshape", vec![], &[IMAGE, N(&[-1, -1])], "the new shape is [-1, -1]"),
        ("Reshape", vec![], &[IMAGE, N(&[7, -1])], "as many numbers as [1, 4, 9, 9]"),
        ("Reshape", vec![], &[IMAGE, N(&[-2, 2])], "the new shape"),
        ("Reshape", vec![], &[IMAGE, N(&[i64::MAX, i64::MAX])], "the new shape"),
        ("Reshape", vec![], &[IMAGE, X(&[2])], "FLOAT, of the inputs"),
        ("Pad", vec![], &[IMAGE, N(&[-1, 0, 0, 0, 0, 0, 0, 0])], "a pad of axis 0 is -1"),
        ("Pad", vec![], &[IMAGE, N(&[1])], "the number of pads is 1, expected 8"),
        ("Pad", vec![text("mode", "wrap")], &[IMAGE, N(&[0; 8])], "expected constant, edge or reflect"),
        ("Pad", vec![text("mode", "reflect")], &[IMAGE, N(&[0, 0, 9, 0, 0, 0, 0, 0])], "expected 0 to 8"),
        ("Split", vec![one("axis", 1)], &[IMAGE, N(&[5])], "expected 1 that add up to 4"),
        ("ReduceMean", vec![many("axes", &[0, 0])], &[IMAGE], "each axis once"),
        ("ReduceMean", vec![many("axes", &[])], &[IMAGE], "axes is an empty list"),
        ("ReduceMean", vec![one("keepdims", 7)], &[IMAGE], "keepdims is 7, expected 0 or 1"),
        ("ReduceSum", vec![many("axes", &[0])], &[IMAGE], "attribute axes is there"),
        ("Add", vec![], &[IMAGE, X(&[5])], "[1, 4, 9, 9] and [5]"),
        ("Add", vec![], &[IMAGE], "the number of operands is 1, expected 2"),
        ("Add", vec![], &[IMAGE, N(&[1])], "the type of operand 2 is INT64, expected FLOAT"),
        ("PRelu", vec![], &[X(&[3]), IMAGE], "the shape of the slope"),
        ("Clip", vec![], &[IMAGE, X(&[9])], "a single number"),
        ("MatMul", vec![], &[X(&[2, 3]), X(&[4, 5])], "[2, 3] and [4, 5]"),
        ("MatMul", vec![], &[X(&[]), X(&[4, 5])], "[] and [4, 5], expected a matrix"),
        ("MatMul", vec![], &[X(&[4]), X(&[4])], "[4] and [4], expected a matrix"),
        ("Gemm", vec![], &[IMAGE, X(&[9, 2])], "expected two axes"),
        ("Gemm", vec![], &[X(&[2, 3]), X(&[3, 5]), X(&[4])], "repeats to [2, 5]"),
        ("Cast", vec![one("to", 8)], &[IMAGE], "to is STRING, expected FLOAT, INT32 or INT64"),
        ("LayerNormalization", vec![one("axis", 4)], &[IMAGE, X(&[9])], "axis is 4"),
        ("InstanceNormalization", vec![], &[IMAGE, X(&[3]), X(&[4])], "[4], one number a channel"),
        ("BatchNormalization", vec![], &[IMAGE, X(&[4]), X(&[4]), X(&[4]), X(&[4])], "expected a weight"),
        ("GlobalMaxPool", vec![], &[X(&[2, 3])], "1 to 3 sides"),
        ("Conv", vec![one("group", 0)], &[IMAGE, KERNEL], "group is 0, expected 1 to the 4 channels"),
        ("Conv", vec![one("group", 3)], &[IMAGE, KERNEL], "in 3 groups"),
        (
            "Conv",
            vec![many("strides", &[0, 1])],
            &[IMAGE, KERNEL],
            "strides is [0, 1], expected 2 numbers from 1",
        ),
        ("Conv", vec![many("dilations", &[1])], &[IMAGE, KERNEL], "dilations is [1]"),
        ("Conv", vec![many("dilations", &[1, i64::MAX])], &[IMAGE, KERNEL], "dilations"),
        (
            "Conv",
            vec![many("dilations", &[1, 9])],
            &[IMAGE, KERNEL],
            "reach along axis 3 is 19, expected at most the 9",
        ),
        (
            "Conv",
            vec![many("pads", &[-1; 4])],
            &[IMAGE, KERNEL],
            "pads is [-1, -1, -1, -1], expected 4 numbers from 0",
        ),
        ("Conv", vec![many("pads", &[1; 3])], &[IMAGE, KERNEL], "pads"),
        ("Conv", vec![many("kernel_shape", &[3, 4])], &[IMAGE, KERNEL], "the kernel's [3, 3]"),
        ("Conv", vec![text("auto_pad", "SOME")], &[IMAGE, KERNEL], "auto_pad is \"SOME\""),
        (
            "Conv",
            vec![text("auto_pad", "VALID"), many("pads", &[0; 4])],
            &[IMAGE, KERNEL],
            "either pads or auto_pad",
        ),
        ("Conv", vec![], &[IMAGE, KERNEL, X(&[5])], "the shape of operand 3 is [5], expected [6]"),
        ("Conv", vec![], &[IMAGE, X(&[6, 4, 3])], "expected 4 axes"),
        ("ConvTranspose", vec![], &[IMAGE, KERNEL], "expected [4, ..]"),
        ("ConvTranspose", vec![many("output_shape", &[1, 1])], &[IMAGE, X(&[4, 6, 3, 3])], "output_shape"),
        (
            "ConvTranspose",
            vec![many("output_padding", &[1, 1])],
            &[IMAGE, X(&[4, 6, 3, 3])],
            "less than the stride 1",
        ),
        (
            "ConvTranspose",
            vec![many("pads", &[9; 4])],
            &[IMAGE, X(&[4, 6, 3, 3])],
            "less than the result's 11",
        ),
        ("MaxPool", vec![], &[IMAGE], "kernel_shape is missing"),
        ("MaxPool", vec![many("kernel_shape", &[0, 3])], &[IMAGE], "kernel_shape is [0, 3]"),
        ("AveragePool", vec![many("kernel_shape", &[2, 2]), many("pads", &[2; 4])], &[IMAGE], "reach of 2"),
    ];
    for (operator, attributes, operands, told) in cases {
        let error = made(operator, attributes, operands).expect_err(operator);
        assert!(matches!(error, GraphError::Node(_)), "{operator}: {error}");
        assert!(error.to_string().contains(told), "{operator}: {error}");
    }
}

#[test]
fn every_operator_that_is_allowed_is_known() {
    for operator in OPERATORS {
        let error = made(operator, vec![], &[]).unwrap_err();
        assert!(matches!(error, GraphError::Node(_)), "{operator}: {error}");
    }
}

/// A graph of functions of `x [1, 8]`.
fn graph(node: Vec<NodeProto>) -> (GraphProto, Signature) {
    let signature = Signature { inputs: vec![TensorSpec::new("x", &[1, 8])], outputs: Vec::new() };
    (GraphProto { node, ..GraphProto::default() }, signature)
}

fn node(operator: &str, inputs: &[&str], output: &str, attribute: Vec<AttributeProto>) -> NodeProto {
    let input = inputs.iter().map(|&input| input.into()).collect();
    NodeProto {
        op_type: operator.into(),
        input,
        output: vec![output.into()],
        attribute,
        ..NodeProto::default()
    }
}

#[test]
fn what_a_graph_makes_and_multiplies_is_bounded() {
    let constant = |name: &str, sides: &[i64]| node("Constant", &[], name, vec![many("value_ints", sides)]);
    let wide = [constant("pads", &[0, 0, 0, 4_000_000]), node("Pad", &["x", "pads"], "y0", vec![])];
    let made: Vec<_> =
        (0..80).map(|i| node("Exp", &[&format!("y{i}")], &format!("y{}", i + 1), vec![])).collect();
    let (graph_of_many, signature) = graph(wide.into_iter().chain(made).collect());
    let error = check_shapes(&graph_of_many, OPSET, &signature).unwrap_err().to_string();
    assert!(error.contains("numbers made by it and the nodes before it"), "{error}");

    let square = [
        constant("pads", &[0, 0, 3999, 3992]),
        node("Pad", &["x", "pads"], "y", vec![]),
        node("MatMul", &["y", "y"], "z", vec![]),
        node("MatMul", &["z", "z"], "w", vec![]),
    ];
    let (products, signature) = graph(square.to_vec());
    let error = check_shapes(&products, OPSET, &signature).unwrap_err().to_string();
    assert!(error.contains("products taken by it") && error.contains("\"w\""), "{error}");
    let (few, signature) = graph(square[..3].to_vec());
    check_shapes(&few, OPSET, &signature).unwrap();
}
