//! Graphs that must be refused before anything runs them.

use super::changed;
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Size;
use tract_onnx::pb::type_proto::Value;
use tract_onnx::pb::{AttributeProto, NodeProto, StringStringEntryProto, TensorProto};
use vantage_learn::{GraphError, Role};

#[test]
fn weights_that_are_not_finite_are_refused() {
    for poison in [f32::NAN, f32::INFINITY] {
        let error = changed(Role::Decoder, |model| {
            let weight = &mut model.graph.as_mut().unwrap().initializer[2];
            weight.raw_data[8..12].copy_from_slice(&poison.to_le_bytes());
        });
        assert!(matches!(error, GraphError::NonFiniteWeight { index: 2, .. }), "{error}");
    }
}

#[test]
fn external_data_is_refused() {
    let error = changed(Role::Measurement, |model| {
        let weight = &mut model.graph.as_mut().unwrap().initializer[1];
        weight.raw_data.clear();
        weight.data_location = Some(1);
        let (key, value) = ("location".to_owned(), "../../etc/passwd".to_owned());
        weight.external_data.push(StringStringEntryProto { key, value });
    });
    assert!(matches!(error, GraphError::ExternalData { .. }), "{error}");
}

#[test]
fn other_operators_are_refused() {
    let error = changed(Role::Image, |model| model.graph.as_mut().unwrap().node[3].op_type = "Loop".into());
    assert!(matches!(&error, GraphError::Operator { operator, .. } if operator == "Loop"), "{error}");
    let error =
        changed(Role::Image, |model| model.graph.as_mut().unwrap().node[3].domain = "com.evil".into());
    assert!(
        matches!(&error, GraphError::Operator { operator, .. } if operator.starts_with("com.evil.")),
        "{error}"
    );
    let error = changed(Role::Image, |model| model.opset_import[0].version = 12);
    assert!(matches!(error, GraphError::Opset { .. }), "{error}");
}

#[test]
fn what_rounds_otherwise_from_processor_to_processor_is_refused() {
    let with = |role: Role, operator: &str, poison: fn(&mut AttributeProto)| {
        changed(role, |model| {
            let nodes = &mut model.graph.as_mut().unwrap().node;
            let node = nodes.iter_mut().find(|node| node.op_type == operator).unwrap();
            poison(&mut node.attribute[0]);
        })
    };
    for (error, refused) in [
        (with(Role::Image, "Cast", |to| to.i = 10), "a Cast to float16"),
        (with(Role::Measurement, "LeakyRelu", |alpha| alpha.f = -0.5), "a LeakyRelu of a negative slope"),
    ] {
        assert!(matches!(&error, GraphError::ProcessorDependent { form, .. } if *form == refused), "{error}");
    }
}

#[test]
fn other_shapes_are_refused() {
    let error = changed(Role::Encoder, |model| model.graph.as_mut().unwrap().initializer[2].dims[0] += 1);
    assert!(matches!(error, GraphError::WeightSize { .. }), "{error}");
    let error =
        changed(Role::Encoder, |model| model.graph.as_mut().unwrap().initializer[2].dims[0] = i64::MAX);
    assert!(matches!(error, GraphError::WeightSize { .. }), "{error}");

    let error = changed(Role::DecoderJacobian, |model| {
        let output = &mut model.graph.as_mut().unwrap().output[1];
        let Some(Value::TensorType(tensor)) = output.r#type.as_mut().unwrap().value.as_mut() else {
            panic!()
        };
        tensor.shape.as_mut().unwrap().dim[1].value = Some(Size::DimValue(31));
    });
    assert!(error.to_string().contains("[6, 31]") && error.to_string().contains("[6, 30]"), "{error}");
    let error =
        changed(Role::Decoder, |model| model.graph.as_mut().unwrap().input[0].name = "embedding".into());
    assert!(matches!(error, GraphError::Signature { side: "inputs", .. }), "{error}");
}

#[test]
fn graphs_that_do_not_compute_what_they_declare_are_refused() {
    let error = changed(Role::Decoder, |model| {
        let graph = model.graph.as_mut().unwrap();
        graph.node.last_mut().unwrap().input[0] = "latent".into();
    });
    assert!(error.to_string().contains("(Gemm): the matrices' shapes is [1, 30] and [256, 6]"), "{error}");
    let error = changed(Role::Decoder, |model| {
        let nodes = &mut model.graph.as_mut().unwrap().node;
        *nodes.last_mut().unwrap() = node("Identity", &["latent"], "measurement");
    });
    assert!(matches!(error, GraphError::Signature { side: "computed outputs", .. }), "{error}");
    let error = changed(Role::Decoder, |model| {
        let graph = model.graph.as_mut().unwrap();
        graph.node.last_mut().unwrap().output[0] = "elsewhere".into();
    });
    assert!(matches!(error, GraphError::Wiring { .. }), "{error}");
    let error = changed(Role::Measurement, |model| model.graph = None);
    assert!(matches!(error, GraphError::Malformed { .. }), "{error}");
}

#[test]
fn tensors_too_large_are_refused_before_they_are_made() {
    let error = changed(Role::Measurement, |model| {
        let nodes = &mut model.graph.as_mut().unwrap().node;
        let first = nodes.iter().position(|node| node.op_type == "Conv").unwrap();
        let mut huge = nodes[first].clone();
        (huge.name, huge.output[0]) = ("huge".into(), "huge".into());
        let pads = huge.attribute.iter_mut().find(|attribute| attribute.name == "pads").unwrap();
        pads.ints = vec![1_000_000; 4];
        nodes[first + 1].input[0] = "with_huge".into();
        let mean = node("GlobalAveragePool", &["huge"], "mean_of_huge");
        nodes.splice(
            first + 1..first + 1,
            [huge, mean, node("Add", &["trunk.0", "mean_of_huge"], "with_huge")],
        );
    });
    assert!(matches!(error, GraphError::TensorSize { .. }), "{error}");
}

/// A node of a graph.
pub fn node(operator: &str, inputs: &[&str], output: &str) -> NodeProto {
    NodeProto {
        name: output.into(),
        op_type: operator.into(),
        input: inputs.iter().map(|&name| name.into()).collect(),
        output: vec![output.into()],
        ..NodeProto::default()
    }
}

#[test]
fn weights_are_not_made_into_large_tensors() {
    let column = TensorProto {
        name: "column".into(),
        dims: vec![65536, 1],
        data_type: 1,
        raw_data: vec![0; 4 * 65536],
        ..TensorProto::default()
    };
    let row = TensorProto { name: "row".into(), dims: vec![1, 65536], ..column.clone() };
    let indices = TensorProto {
        name: "indices".into(),
        dims: vec![65536],
        data_type: 7,
        raw_data: vec![0; 8 * 65536],
        ..TensorProto::default()
    };
    let pads = TensorProto {
        name: "pads".into(),
        dims: vec![4],
        raw_data: [0i64, 0, 8000, 0].iter().flat_map(|pad| pad.to_le_bytes()).collect(),
        ..indices.clone()
    };
    let with = |nodes: &[NodeProto]| {
        let (column, row) = (column.clone(), row.clone());
        let (indices, pads) = (indices.clone(), pads.clone());
        changed(Role::Measurement, move |model| {
            let graph = model.graph.as_mut().unwrap();
            graph.initializer.extend([column, row, indices, pads]);
            graph.node.splice(0..0, nodes.iter().cloned());
        })
    };
    let product = [node("Mul", &["column", "row"], "made")];
    let sum_with_turned = [node("Transpose", &["row"], "turned"), node("Add", &["turned", "row"], "made")];
    let repeated = |operator: &str, inputs: &[&str]| -> Vec<_> {
        (0..3900).map(|i| node(operator, inputs, &format!("made{i}"))).collect()
    };
    let (one_by_one, dot_products) = (repeated("Exp", &["row"]), repeated("MatMul", &["row", "column"]));
    let gathered = [node("Gather", &["row", "indices"], "made")];
    let product_of_matrices = [node("MatMul", &["column", "row"], "made")];
    let padded = [node("Pad", &["row", "pads"], "made")];
    let all = [
        &product[..],
        &sum_with_turned,
        &one_by_one,
        &dot_products,
        &gathered,
        &product_of_matrices,
        &padded,
    ];
    for nodes in all {
        let error = with(nodes);
        let named = matches!(&error, GraphError::Stored { node, .. } if node.starts_with("made"));
        assert!(named, "{error}");
    }
}

#[test]
fn more_nodes_than_a_network_needs_are_refused_at_once() {
    for count in [5_000, 50_000] {
        let error = changed(Role::Measurement, |model| {
            let chain = (0..count).map(|i| node("Abs", &["crop"], &format!("crop{i}")));
            model.graph.as_mut().unwrap().node.extend(chain);
        });
        assert!(matches!(error, GraphError::Nodes { nodes, limit: 4096 } if nodes > count), "{error}");
    }
}
