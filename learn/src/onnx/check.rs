//! Structural checks of an ONNX model, before any runtime sees it.

use super::error::GraphError;
use super::infer::check_shapes;
use super::{OPERATORS, OPSETS, Signature, TensorSpec};
use half::f16;
use prost::Message;
use std::collections::BTreeSet;
use tract_onnx::pb::tensor_proto::{DataLocation, DataType};
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Dimension;
use tract_onnx::pb::type_proto::Value;
use tract_onnx::pb::{AttributeProto, GraphProto, ModelProto, NodeProto, TensorProto, ValueInfoProto};

/// Most nodes and weights of a graph: several times those of large networks. The runtime's time grows with their square.
const MOST_NODES: usize = 4096;
/// Most axes of a weight.
const MOST_AXES: usize = 8;

/// Decodes a model and checks everything but what its numbers compute.
pub(crate) fn checked_model(bytes: &[u8], signature: &Signature) -> Result<ModelProto, GraphError> {
    let malformed = |reason: String| GraphError::Malformed { bytes: bytes.len(), reason };
    let model = ModelProto::decode(bytes).map_err(|error| malformed(error.to_string()))?;
    let graph = model.graph.as_ref().ok_or_else(|| malformed("no graph in it".into()))?;
    let opset = check_opset(&model)?;
    let nodes = graph.node.len().saturating_add(graph.initializer.len());
    if nodes > MOST_NODES {
        return Err(GraphError::Nodes { nodes, limit: MOST_NODES });
    }
    check_features(&model, graph)?;
    for node in &graph.node {
        check_node(node)?;
    }
    for weight in &graph.initializer {
        check_weight(weight, &weight.name)?;
    }
    check_side("inputs", &graph.input, &signature.inputs)?;
    check_side("outputs", &graph.output, &signature.outputs)?;
    check_wiring(graph)?;
    check_shapes(graph, opset, signature)?;
    Ok(model)
}

fn check_opset(model: &ModelProto) -> Result<i64, GraphError> {
    let domain = |name: &str| if name.is_empty() { "ai.onnx".to_owned() } else { name.to_owned() };
    let imports: Vec<_> = model.opset_import.iter().map(|o| (domain(&o.domain), o.version)).collect();
    match imports.as_slice() {
        [(domain, version)] if domain == "ai.onnx" && OPSETS.contains(version) => Ok(*version),
        _ => {
            let got: Vec<_> = imports.iter().map(|(domain, version)| format!("{domain} {version}")).collect();
            Err(GraphError::Opset { got: format!("[{}]", got.join(", ")) })
        }
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
        let (node, operator) = (node.name.clone(), prefix + &node.op_type);
        return Err(GraphError::Operator { node, operator, expected: &OPERATORS });
    }
    if let Some((form, remedy)) = processor_dependent(node) {
        return Err(GraphError::ProcessorDependent { node: node.name.clone(), form, remedy });
    }
    let constant = node.op_type == "Constant";
    for attribute in &node.attribute {
        match &attribute.t {
            Some(weight) if constant => check_weight(weight, &node.name)?,
            _ if nested(attribute) => {
                let what =
                    format!("a tensor or graph in attribute {:?} of node {:?}", attribute.name, node.name);
                return Err(GraphError::Unsupported { what });
            }
            _ => {}
        }
        if let Some(index) =
            attribute.floats.iter().chain([&attribute.f]).position(|value| !value.is_finite())
        {
            let value = attribute.floats.get(index).copied().unwrap_or(attribute.f);
            return Err(GraphError::NonFiniteWeight { tensor: node.name.clone(), index, value });
        }
    }
    Ok(())
}

/// Forms of operators of which tract makes other bits on one processor than on another, and what to write in their place.
fn processor_dependent(node: &NodeProto) -> Option<(&'static str, &'static str)> {
    let any = |name: &str, bad: fn(&AttributeProto) -> bool| {
        node.attribute.iter().any(|attribute| attribute.name == name && bad(attribute))
    };
    let is_half: fn(&AttributeProto) -> bool = |to| to.i == i64::from(DataType::Float16 as i32);
    let in_single = "compute in float32; float16 is for weights alone";
    match node.op_type.as_str() {
        "Cast" if any("to", is_half) => Some(("a Cast to float16", in_single)),
        "LayerNormalization" if any("stash_type", is_half) => {
            Some(("a LayerNormalization in float16", in_single))
        }
        "LeakyRelu" if any("alpha", |alpha| alpha.f.is_sign_negative()) => {
            Some(("a LeakyRelu of a negative slope", "write it as Relu, Mul and Sub"))
        }
        _ => None,
    }
}

fn nested(a: &AttributeProto) -> bool {
    a.t.is_some()
        || a.g.is_some()
        || a.sparse_tensor.is_some()
        || !a.tensors.is_empty()
        || !a.graphs.is_empty()
        || !a.sparse_tensors.is_empty()
}

/// A weight of the graph, or of the `Constant` node `name`.
fn check_weight(weight: &TensorProto, name: &str) -> Result<(), GraphError> {
    let tensor = || name.to_owned();
    if weight.data_location == Some(DataLocation::External as i32) || !weight.external_data.is_empty() {
        return Err(GraphError::ExternalData { tensor: tensor() });
    }
    let unsupported =
        |what: &str| Err(GraphError::Unsupported { what: format!("{what} of weight {name:?}") });
    let width = match DataType::try_from(weight.data_type) {
        Ok(DataType::Float | DataType::Int32) => 4usize,
        Ok(DataType::Float16) => 2,
        Ok(DataType::Int64) => 8,
        _ => return unsupported(&format!("data type {}", weight.data_type)),
    };
    let typed = !weight.float_data.is_empty()
        || !weight.int64_data.is_empty()
        || !weight.int32_data.is_empty()
        || !weight.double_data.is_empty()
        || !weight.uint64_data.is_empty()
        || !weight.string_data.is_empty()
        || weight.segment.is_some();
    if typed {
        return unsupported("typed or split data");
    }
    let list_of_none = weight.dims == [0] && weight.data_type == DataType::Int64 as i32;
    if weight.dims.len() > MOST_AXES || (weight.dims.contains(&0) && !list_of_none) {
        return unsupported(&format!("a shape with an empty side or more than {MOST_AXES} axes"));
    }
    let volume =
        weight.dims.iter().try_fold(1usize, |volume, &dim| volume.checked_mul(usize::try_from(dim).ok()?));
    let expected = volume.and_then(|volume| volume.checked_mul(width)).unwrap_or(usize::MAX);
    if weight.raw_data.len() != expected {
        let (shape, got) = (weight.dims.clone(), weight.raw_data.len());
        return Err(GraphError::WeightSize { tensor: tensor(), shape, got, expected });
    }
    match numbers(weight).iter().enumerate().find(|(_, value)| !value.is_finite()) {
        Some((index, &value)) => Err(GraphError::NonFiniteWeight { tensor: tensor(), index, value }),
        None => Ok(()),
    }
}

/// The numbers of a weight that is not of integers.
pub(super) fn numbers(weight: &TensorProto) -> Vec<f32> {
    match DataType::try_from(weight.data_type) {
        Ok(DataType::Float) => {
            let bytes = weight.raw_data.chunks_exact(4);
            bytes.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
        }
        Ok(DataType::Float16) => {
            let bytes = weight.raw_data.chunks_exact(2);
            bytes.map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect()
        }
        _ => Vec::new(),
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
        // An empty name stands for an optional input or output that is left out.
        let named = |name: &&String| !name.is_empty();
        if let Some(name) = node.input.iter().filter(named).find(|name| !defined.contains(*name)) {
            return Err(undefined(name));
        }
        for name in node.output.iter().filter(named) {
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
