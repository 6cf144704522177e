//! Writing ONNX graphs node by node, with names and shapes of our choosing.

use super::{Signature, TensorSpec};
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

/// Operator set of the files written.
const OPSET: i64 = 17;
/// IR version that goes with [`OPSET`].
const IR_VERSION: i64 = 8;

/// A graph in the making. Every method that adds a node returns the name of its output.
pub(crate) struct GraphBuilder {
    graph: GraphProto,
}

impl GraphBuilder {
    /// A graph with its inputs and outputs declared.
    pub(crate) fn new(name: &str, signature: &Signature) -> Self {
        let declare = |tensors: &[TensorSpec]| tensors.iter().map(declaration).collect();
        let (input, output) = (declare(&signature.inputs), declare(&signature.outputs));
        Self { graph: GraphProto { name: name.into(), input, output, ..GraphProto::default() } }
    }

    /// A weight of `f32`, row-major.
    pub(crate) fn weight(&mut self, name: &str, shape: &[usize], data: &[f32]) -> String {
        debug_assert_eq!(shape.iter().product::<usize>(), data.len(), "{name}");
        let raw = data.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.initializer(name, shape, DataType::Float, raw)
    }

    /// A weight that half precision holds without loss, stored so.
    pub(crate) fn half_weight(&mut self, name: &str, shape: &[usize], data: &[f32]) -> String {
        debug_assert_eq!(shape.iter().product::<usize>(), data.len(), "{name}");
        debug_assert!(data.iter().all(|&value| f16::from_f32(value).to_f32() == value), "{name}");
        let raw = data.iter().flat_map(|&value| f16::from_f32(value).to_le_bytes()).collect();
        let stored = self.initializer(&format!("{name}.half"), shape, DataType::Float16, raw);
        let to = vec![integer("to", i64::from(DataType::Float as i32))];
        self.node_with("Cast", &[&stored], &[name], to);
        name.to_owned()
    }

    /// A vector of sizes, as `Split` and `Reshape` take them.
    pub(crate) fn sizes(&mut self, name: &str, sizes: &[usize]) -> String {
        let sizes: Vec<i64> = sizes.iter().map(|&size| size as i64).collect();
        self.integers(name, &sizes)
    }

    /// A list of integers.
    pub(crate) fn integers(&mut self, name: &str, integers: &[i64]) -> String {
        let raw = integers.iter().flat_map(|integer| integer.to_le_bytes()).collect();
        self.initializer(name, &[integers.len()], DataType::Int64, raw)
    }

    /// A node of one output, which it is named after.
    pub(crate) fn node(&mut self, operator: &str, inputs: &[&str], output: &str) -> String {
        self.node_with(operator, inputs, &[output], Vec::new());
        output.to_owned()
    }

    /// A node with attributes.
    pub(crate) fn node_with(
        &mut self,
        operator: &str,
        inputs: &[&str],
        outputs: &[&str],
        attribute: Vec<AttributeProto>,
    ) {
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        self.graph.node.push(NodeProto {
            name: outputs[0].into(),
            op_type: operator.into(),
            input: owned(inputs),
            output: owned(outputs),
            attribute,
            ..NodeProto::default()
        });
    }

    /// `Concat` along the last of two axes.
    pub(crate) fn concat(&mut self, inputs: &[&str], output: &str) -> String {
        self.node_with("Concat", inputs, &[output], vec![integer("axis", 1)]);
        output.to_owned()
    }

    /// `Split` along the last of two axes.
    pub(crate) fn split<const N: usize>(&mut self, input: &str, parts: [(&str, usize); N]) -> [String; N] {
        let sizes = self.sizes(&format!("{}.sizes", parts[0].0), &parts.map(|(_, size)| size));
        self.node_with("Split", &[input, &sizes], &parts.map(|(name, _)| name), vec![integer("axis", 1)]);
        parts.map(|(name, _)| name.to_owned())
    }

    /// The model's bytes.
    pub(crate) fn finish(self) -> Vec<u8> {
        let model = ModelProto {
            ir_version: IR_VERSION,
            opset_import: vec![OperatorSetIdProto { domain: String::new(), version: OPSET }],
            producer_name: env!("CARGO_PKG_NAME").into(),
            producer_version: env!("CARGO_PKG_VERSION").into(),
            graph: Some(self.graph),
            ..ModelProto::default()
        };
        model.encode_to_vec()
    }

    fn initializer(&mut self, name: &str, shape: &[usize], kind: DataType, raw_data: Vec<u8>) -> String {
        self.graph.initializer.push(TensorProto {
            name: name.into(),
            dims: shape.iter().map(|&size| size as i64).collect(),
            data_type: kind as i32,
            raw_data,
            ..TensorProto::default()
        });
        name.to_owned()
    }
}

/// An integer attribute.
pub(crate) fn integer(name: &str, value: i64) -> AttributeProto {
    AttributeProto {
        name: name.into(),
        r#type: AttributeType::Int as i32,
        i: value,
        ..AttributeProto::default()
    }
}

/// A real attribute.
pub(crate) fn real(name: &str, value: f32) -> AttributeProto {
    AttributeProto {
        name: name.into(),
        r#type: AttributeType::Float as i32,
        f: value,
        ..AttributeProto::default()
    }
}

/// An attribute of integers.
pub(crate) fn integers(name: &str, values: &[i64]) -> AttributeProto {
    let (name, ints) = (name.into(), values.to_vec());
    AttributeProto { name, r#type: AttributeType::Ints as i32, ints, ..AttributeProto::default() }
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
