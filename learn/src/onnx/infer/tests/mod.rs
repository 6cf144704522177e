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

/// Numbers of the inputs.
fn input(shape: &[usize]) -> Tensor {
    Tensor::new(DataType::Float, shape.to_vec())
}

fn weight(shape: &[usize]) -> Tensor {
    Tensor { stored: true, ..input(shape) }
}

/// A weight that is a list of integers.
fn list(integers: &[i64]) -> Tensor {
    Tensor::of_integers(vec![integers.len()], integers)
}

/// An integer, integers, or text.
#[derive(Clone)]
enum Value {
    One(i64),
    Many(Vec<i64>),
    Text(String),
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

fn made(
    opset: i64,
    operator: &str,
    attribute: Vec<AttributeProto>,
    operands: &[Tensor],
    outputs: usize,
) -> Result<Vec<Vec<usize>>, GraphError> {
    let output = (0..outputs).map(|index| format!("out{index}")).collect();
    let proto = NodeProto { op_type: operator.into(), attribute, output, ..NodeProto::default() };
    let node = Node::new(&proto, opset, operands.iter().map(Some).collect())?;
    Ok(results(&node)?.into_iter().map(|result| result.shape).collect())
}

/// What comes of a node as a corpus writes it: operator, attributes, and operands, which are `x` of the inputs, `w` a weight, each
/// with its shape, or `n` a weight of these integers. `ReduceMean:18` is that of operator set 18.
fn made_of(node: &str, outputs: usize) -> Result<Vec<Vec<usize>>, GraphError> {
    let mut words = node.split(' ');
    let operator = words.next().unwrap();
    let (operator, opset) =
        operator.split_once(':').map_or((operator, OPSET), |(name, set)| (name, set.parse().unwrap()));
    let (mut attributes, mut operands) = (Vec::new(), Vec::new());
    for word in words {
        match (word.split_once('='), word.split_at(1)) {
            (Some((name, value)), _) => {
                let value = match value.parse() {
                    Ok(one) => Value::One(one),
                    Err(_) if value.starts_with('[') => Value::Many(serde_json::from_str(value).unwrap()),
                    Err(_) => Value::Text(value.into()),
                };
                attributes.push(attribute(name, &value));
            }
            (None, ("x", shape)) => operands.push(input(&serde_json::from_str::<Vec<_>>(shape).unwrap())),
            (None, ("w", shape)) => operands.push(weight(&serde_json::from_str::<Vec<_>>(shape).unwrap())),
            (None, ("n", integers)) => {
                operands.push(list(&serde_json::from_str::<Vec<_>>(integers).unwrap()))
            }
            _ => panic!("{word} in {node}"),
        }
    }
    made(opset, operator, attributes, &operands, outputs)
}

/// Nodes of a corpus, a line each, and what is said of them.
fn cases(corpus: &str) -> impl Iterator<Item = (&str, &str)> {
    corpus.lines().map(|line| line.split_once(" -> ").unwrap())
}

#[test]
fn shapes_are_those_of_the_operators() {
    for (node, expected) in cases(include_str!("shapes.txt")) {
        let expected: Vec<Vec<usize>> =
            expected.split(' ').map(|shape| serde_json::from_str(shape).unwrap()).collect();
        let shapes = made_of(node, expected.len()).unwrap_or_else(|error| panic!("{node}: {error}"));
        assert_eq!(shapes, expected, "{node}");
    }
}

#[test]
fn what_does_not_fit_is_told_with_what_was_expected() {
    for (node, told) in cases(include_str!("faults.txt")) {
        let error = made_of(node, 1).expect_err(node);
        assert!(matches!(error, GraphError::Node(_)), "{node}: {error}");
        assert!(error.to_string().contains(told), "{node}: {error}");
    }
}

#[test]
fn every_operator_that_is_allowed_is_known() {
    for operator in OPERATORS {
        let error = made_of(operator, 1).unwrap_err();
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
