//! ONNX graphs of a few nodes, as other programs write them.

use half::f16;
use prost::Message;
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::tensor_shape_proto::{Dimension, dimension::Value as Size};
use tract_onnx::pb::type_proto::{Tensor, Value};
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, OperatorSetIdProto, TensorProto, TensorShapeProto,
    TypeProto, ValueInfoProto,
};
use vantage_learn::{Signature, TensorSpec};

/// A graph with its inputs and outputs declared.
pub fn graph(signature: &Signature) -> GraphProto {
    let declared = |side: &[TensorSpec]| side.iter().map(declaration).collect();
    GraphProto {
        name: "foreign".into(),
        input: declared(&signature.inputs),
        output: declared(&signature.outputs),
        ..GraphProto::default()
    }
}

/// The file of a graph.
pub fn file(graph: GraphProto, opset: i64) -> Vec<u8> {
    let opset_import = vec![OperatorSetIdProto { domain: String::new(), version: opset }];
    ModelProto { ir_version: 8, opset_import, graph: Some(graph), ..ModelProto::default() }.encode_to_vec()
}

pub fn add_node(graph: &mut GraphProto, operator: &str, inputs: &[&str], output: &str) {
    graph.node.push(NodeProto {
        op_type: operator.into(),
        name: output.into(),
        input: inputs.iter().map(|&name| name.into()).collect(),
        output: vec![output.into()],
        ..NodeProto::default()
    });
}

/// A weight in the list of weights.
pub fn add_weight(graph: &mut GraphProto, name: &str, shape: &[usize], data: &[f32]) {
    let raw = data.iter().flat_map(|number| number.to_le_bytes()).collect();
    graph.initializer.push(tensor(name, shape, DataType::Float, raw));
}

/// A weight of half precision, and its `Cast` to `f32`.
pub fn add_half_weight(graph: &mut GraphProto, name: &str, shape: &[usize], data: &[f32]) {
    let raw = data.iter().flat_map(|&number| f16::from_f32(number).to_le_bytes()).collect();
    let half = format!("{name}.half");
    graph.initializer.push(tensor(&half, shape, DataType::Float16, raw));
    add_node(graph, "Cast", &[&half], name);
    let to = AttributeProto { i: DataType::Float as i64, ..attribute("to", AttributeType::Int) };
    graph.node.last_mut().unwrap().attribute.push(to);
}

/// A weight in a `Constant` node.
pub fn add_constant(graph: &mut GraphProto, name: &str, shape: &[usize], data: &[f32]) {
    let raw = data.iter().flat_map(|number| number.to_le_bytes()).collect();
    add_node(graph, "Constant", &[], name);
    let value = Some(tensor("", shape, DataType::Float, raw));
    let attribute = AttributeProto { t: value, ..attribute("value", AttributeType::Tensor) };
    graph.node.last_mut().unwrap().attribute.push(attribute);
}

fn attribute(name: &str, kind: AttributeType) -> AttributeProto {
    AttributeProto { name: name.into(), r#type: kind as i32, ..AttributeProto::default() }
}

fn tensor(name: &str, shape: &[usize], kind: DataType, raw_data: Vec<u8>) -> TensorProto {
    TensorProto {
        name: name.into(),
        dims: shape.iter().map(|&size| size as i64).collect(),
        data_type: kind as i32,
        raw_data,
        ..TensorProto::default()
    }
}

fn declaration(tensor: &TensorSpec) -> ValueInfoProto {
    let dimension =
        |&size: &usize| Dimension { value: Some(Size::DimValue(size as i64)), ..Dimension::default() };
    let shape = TensorShapeProto { dim: tensor.shape.iter().map(dimension).collect() };
    let kind = Tensor { elem_type: DataType::Float as i32, shape: Some(shape) };
    ValueInfoProto {
        name: tensor.name.clone(),
        r#type: Some(TypeProto { value: Some(Value::TensorType(kind)), ..TypeProto::default() }),
        ..ValueInfoProto::default()
    }
}
