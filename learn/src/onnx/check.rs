//! Structural checks of an ONNX model, before any runtime sees it.

use super::error::GraphError;
use super::{OPERATORS, OPSET, Signature, TensorSpec};
use prost::Message;
use std::collections::BTreeSet;
use tract_onnx::pb::tensor_proto::{DataLocation, DataType};
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Dimension;
use tract_onnx::pb::type_proto::Value;
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto, TensorProto, ValueInfoProto};

/// Decodes a model and checks everything but what its numbers compute.
pub(crate) fn checked_model(bytes: &[u8], signature: &Signature) -> Result<ModelProto, GraphError> {
    let malformed = |reason: String| GraphError::Malformed { bytes: bytes.len(), reason };
    let model = ModelProto::decode(bytes).map_err(|error| malformed(error.to_string()))?;
    let graph = model.graph.as_ref().ok_or_else(|| malformed("no graph in it".into()))?;
    check_opset(&model)?;
    check_features(&model, graph)?;
    for node in &graph.node {
        check_node(node)?;
    }
    for weight in &graph.initializer {
        check_weight(weight)?;
    }
    check_side("inputs", &graph.input, &signature.inputs)?;
    check_side("outputs", &graph.output, &signature.outputs)?;
    check_wiring(graph)?;
    Ok(model)
}

fn check_opset(model: &ModelProto) -> Result<(), GraphError> {
    let imports: Vec<_> = model.opset_import.iter().map(|o| (o.domain.clone(), o.version)).collect();
    match imports.as_slice() {
        [(domain, OPSET)] if domain.is_empty() || domain == "ai.onnx" => Ok(()),
        _ => Err(GraphError::Opset { got: imports }),
    }
}

fn check_features(model: &ModelProto, graph: &GraphProto) -> Result<(), GraphError> {
    let present = [
        (!model.functions.is_empty(), "a local function"),
        (!model.training_info.is_empty(), "training info"),
        (!graph.sparse_initializer.is_empty(), "a sparse weight"),
        (!graph.quantization_annotation.is_empty(), "quantization"),
    ];
    match present.iter().find(|(present, _)| *present) {
        Some((_, what)) => Err(GraphError::Unsupported { what: (*what).into() }),
        None => Ok(()),
    }
}

fn check_node(node: &NodeProto) -> Result<(), GraphError> {
    let standard = node.domain.is_empty() || node.domain == "ai.onnx";
    if !standard || !OPERATORS.contains(&node.op_type.as_str()) {
        let prefix = if standard { String::new() } else { format!("{}.", node.domain) };
        return Err(GraphError::Operator { node: node.name.clone(), operator: prefix + &node.op_type });
    }
    let nested = |a: &tract_onnx::pb::AttributeProto| {
        a.t.is_some()
            || a.g.is_some()
            || a.sparse_tensor.is_some()
            || !a.tensors.is_empty()
            || !a.graphs.is_empty()
            || !a.sparse_tensors.is_empty()
    };
    match node.attribute.iter().find(|attribute| nested(attribute)) {
        Some(attribute) => Err(GraphError::Unsupported {
            what: format!("a tensor or graph in attribute {:?} of node {:?}", attribute.name, node.name),
        }),
        None => Ok(()),
    }
}

fn check_weight(weight: &TensorProto) -> Result<(), GraphError> {
    let tensor = || weight.name.clone();
    if weight.data_location == Some(DataLocation::External as i32) || !weight.external_data.is_empty() {
        return Err(GraphError::ExternalData { tensor: tensor() });
    }
    let width = match DataType::try_from(weight.data_type) {
        Ok(DataType::Float) => 4usize,
        Ok(DataType::Int64) => 8,
        _ => {
            let what = format!("data type {} of weight {:?}", weight.data_type, weight.name);
            return Err(GraphError::Unsupported { what });
        }
    };
    let typed = !weight.float_data.is_empty()
        || !weight.int64_data.is_empty()
        || !weight.int32_data.is_empty()
        || !weight.double_data.is_empty()
        || !weight.uint64_data.is_empty()
        || !weight.string_data.is_empty()
        || weight.segment.is_some();
    if typed {
        return Err(GraphError::Unsupported {
            what: format!("typed or split data of weight {:?}", weight.name),
        });
    }
    let volume =
        weight.dims.iter().try_fold(1usize, |volume, &dim| volume.checked_mul(usize::try_from(dim).ok()?));
    let expected = volume.and_then(|volume| volume.checked_mul(width)).unwrap_or(usize::MAX);
    if weight.raw_data.len() != expected {
        let (shape, got) = (weight.dims.clone(), weight.raw_data.len());
        return Err(GraphError::WeightSize { tensor: tensor(), shape, got, expected });
    }
    let floats = || weight.raw_data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    match floats().enumerate().find(|(_, value)| width == 4 && !value.is_finite()) {
        Some((index, value)) => Err(GraphError::NonFiniteWeight { tensor: tensor(), index, value }),
        None => Ok(()),
    }
}

/// Every name is defined once, and before it is used.
fn check_wiring(graph: &GraphProto) -> Result<(), GraphError> {
    let mut defined = BTreeSet::new();
    let define = |name: &str, defined: &mut BTreeSet<String>| match defined.insert(name.to_owned()) {
        true => Ok(()),
        false => Err(GraphError::Wiring { tensor: name.to_owned(), fault: "is defined twice" }),
    };
    let undefined =
        |name: &String| GraphError::Wiring { tensor: name.clone(), fault: "is used but not defined" };
    let sources = graph.input.iter().map(|input| &input.name);
    for name in sources.chain(graph.initializer.iter().map(|weight| &weight.name)) {
        define(name, &mut defined)?;
    }
    for node in &graph.node {
        if let Some(name) = node.input.iter().find(|name| !defined.contains(*name)) {
            return Err(undefined(name));
        }
        for name in &node.output {
            define(name, &mut defined)?;
        }
    }
    match graph.output.iter().find(|output| !defined.contains(&output.name)) {
        Some(output) => Err(undefined(&output.name)),
        None => Ok(()),
    }
}

/// A tensor as declared: its name, and its shape where it is a fixed one of `f32`.
fn declared(info: &ValueInfoProto) -> (String, Option<TensorSpec>) {
    let Some(Value::TensorType(tensor)) = info.r#type.as_ref().and_then(|t| t.value.as_ref()) else {
        return (format!("{:?} without type", info.name), None);
    };
    let dims = tensor.shape.iter().flat_map(|shape| &shape.dim).map(|dim| match &dim.value {
        Some(Dimension::DimValue(value)) => (value.to_string(), usize::try_from(*value).ok()),
        Some(Dimension::DimParam(name)) => (name.clone(), None),
        None => ("?".into(), None),
    });
    let (text, shape): (Vec<_>, Vec<_>) = dims.unzip();
    let float = tensor.elem_type == DataType::Float as i32;
    let kind = DataType::try_from(tensor.elem_type).map_or("an unknown type", |t| t.as_str_name());
    let spec = shape.into_iter().collect::<Option<Vec<_>>>().filter(|_| float);
    (
        format!("{:?} {kind} [{}]", info.name, text.join(", ")),
        spec.map(|shape| TensorSpec { name: info.name.clone(), shape }),
    )
}

fn check_side(side: &'static str, got: &[ValueInfoProto], expected: &[TensorSpec]) -> Result<(), GraphError> {
    let (texts, specs): (Vec<_>, Vec<_>) = got.iter().map(declared).unzip();
    if specs.len() == expected.len()
        && specs.iter().zip(expected).all(|(got, want)| got.as_ref() == Some(want))
    {
        return Ok(());
    }
    let wanted: Vec<_> = expected.iter().map(|t| format!("{:?} FLOAT {:?}", t.name, t.shape)).collect();
    Err(GraphError::Signature { side, got: texts.join(", "), expected: wanted.join(", ") })
}
