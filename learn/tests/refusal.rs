//! Folders that must be refused, each for the right reason.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod support;

use prost::Message;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use support::tiny_model;
use tempfile::TempDir;
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Size;
use tract_onnx::pb::type_proto::Value;
use tract_onnx::pb::{AttributeProto, ModelProto, NodeProto, StringStringEntryProto, TensorProto};
use vantage_learn::{
    CANARY, EmbeddingModel, GraphError, INSTANCE_LIST, Kind, LARGEST_FILE, MANIFEST, ModelError,
    PredictiveModel, Role, ViewpointModel,
};

fn copied() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files() {
        fs::copy(tiny_model().join(&file), folder.path().join(&file)).unwrap();
    }
    folder
}

fn files() -> Vec<String> {
    let graphs = Kind::ViewpointDependent.roles().iter().map(|(role, _)| role.file());
    graphs.chain([MANIFEST, CANARY, INSTANCE_LIST].map(String::from)).collect()
}

fn error(folder: &TempDir) -> ModelError {
    ViewpointModel::load(folder.path()).unwrap_err()
}

/// The error of a folder whose graph of a role was changed.
fn changed(role: Role, change: impl FnOnce(&mut ModelProto)) -> GraphError {
    let folder = copied();
    change_graph(&folder, role, change);
    match error(&folder) {
        ModelError::Graph { path, source } => {
            assert_eq!(path, folder.path().join(role.file()));
            source
        }
        other => panic!("{other}"),
    }
}

fn change_graph(folder: &TempDir, role: Role, change: impl FnOnce(&mut ModelProto)) -> Vec<u8> {
    let path = folder.path().join(role.file());
    let mut model = ModelProto::decode(&*fs::read(&path).unwrap()).unwrap();
    change(&mut model);
    fs::write(&path, model.encode_to_vec()).unwrap();
    model.encode_to_vec()
}

fn change_manifest(folder: &TempDir, change: impl FnOnce(&mut serde_json::Value)) {
    let path = folder.path().join(MANIFEST);
    let mut manifest = serde_saphyr::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    change(&mut manifest);
    // JSON is YAML.
    fs::write(&path, serde_json::to_vec(&manifest).unwrap()).unwrap();
}

fn remove(manifest: &mut serde_json::Value, key: &str) {
    manifest.as_object_mut().unwrap().remove(key).unwrap();
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn an_unchanged_copy_loads() {
    ViewpointModel::load(copied().path()).unwrap();
}

#[test]
fn any_missing_file_is_named() {
    for file in files() {
        let folder = copied();
        fs::remove_file(folder.path().join(&file)).unwrap();
        let error = error(&folder);
        assert!(matches!(&error, ModelError::Read { path, .. } if path.ends_with(&file)), "{error}");
    }
    assert!(matches!(ViewpointModel::load(Path::new("no/such/folder")), Err(ModelError::Read { .. })));
}

#[test]
fn truncated_files_are_refused_at_any_length() {
    for file in files() {
        let whole = fs::read(tiny_model().join(&file)).unwrap();
        // A manifest without its last line break is as good.
        let whole = if file == MANIFEST { whole.trim_ascii_end() } else { &whole };
        for part in [0, 1, 7, whole.len() / 3, whole.len() / 2, whole.len() - 1] {
            let folder = copied();
            fs::write(folder.path().join(&file), &whole[..part]).unwrap();
            let error = error(&folder);
            assert!(error.to_string().contains(&file), "{file} cut to {part} bytes: {error}");
        }
    }
}

#[test]
fn files_too_large_are_not_read() {
    let folder = copied();
    fs::File::options()
        .write(true)
        .open(folder.path().join("encoder.onnx"))
        .and_then(|file| file.set_len(LARGEST_FILE + 1))
        .unwrap();
    assert!(matches!(error(&folder), ModelError::TooLarge { limit: LARGEST_FILE, .. }));
}

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
    assert!(matches!(error, GraphError::Refused { .. }), "{error}");
    let error = changed(Role::Decoder, |model| {
        let graph = model.graph.as_mut().unwrap();
        graph.node.last_mut().unwrap().output[0] = "elsewhere".into();
    });
    assert!(matches!(error, GraphError::Wiring { .. }), "{error}");
    let error = changed(Role::Measurement, |model| model.graph = None);
    assert!(matches!(error, GraphError::Malformed { .. }), "{error}");
}

#[test]
fn a_graph_of_another_model_is_noticed_by_hash_and_by_canary() {
    let folder = copied();
    let bytes = change_graph(&folder, Role::Decoder, |model| {
        let weight = &mut model.graph.as_mut().unwrap().initializer[4];
        weight.raw_data[..4].copy_from_slice(&3.5f32.to_le_bytes());
        let bias = model.graph.as_mut().unwrap().initializer.last_mut().unwrap();
        bias.raw_data[..4].copy_from_slice(&9f32.to_le_bytes());
    });
    assert!(matches!(error(&folder), ModelError::Hash { .. }));
    change_manifest(&folder, |manifest| {
        manifest["graphs"]["decoder"]["sha256"] = sha256(&bytes).into();
    });
    let error = error(&folder);
    assert!(matches!(&error, ModelError::Canary { output, .. } if output == "measurement"), "{error}");
}

#[test]
fn manifests_of_other_versions_or_with_contradictions_are_refused() {
    type Change = fn(&mut serde_json::Value);
    let cases: [(Change, &str); 21] = [
        (|m| m["version"] = 1.into(), "version 1"),
        (|m| m["format"] = "another".into(), "another"),
        (|m| m["surprise"] = 1.into(), "surprise"),
        (|m| m["kind"] = "generative".into(), "generative"),
        (|m| m["kind"] = "viewpoint_predictive".into(), "azimuth_harmonics"),
        (|m| m["kind"] = "embedding".into(), "measurement"),
        (|m| m["conditioning"] = "camera_motion".into(), "camera_motion"),
        (|m| m["conditioning"] = "yaw".into(), "yaw"),
        (|m| remove(m, "conditioning"), "missing"),
        (|m| remove(m, "residual"), "residual is missing"),
        (|m| remove(m, "measurement"), "measurement"),
        (|m| m["latent"]["dimension"] = 31.into(), "latent.steerable"),
        (|m| m["latent"]["steerable"]["invariant"] = 11.into(), "latent.steerable"),
        (|m| m["latent"]["dimension"] = 0.into(), "latent.dimension"),
        (|m| m["residual"]["degrees_of_freedom"] = 0.into(), "degrees_of_freedom"),
        (|m| m["graphs"]["encoder"]["inputs"]["crop"][1] = 1.into(), "graphs.encoder.inputs"),
        (|m| remove(&mut m["graphs"], "decoder"), "graphs.decoder is missing"),
        (|m| m["graphs"]["image"]["file"] = "../image.onnx".into(), "../image.onnx"),
        (|m| m["canary"]["file"] = "/etc/passwd".into(), "/etc/passwd"),
        (|m| m["canary"]["sha256"] = "12e4".into(), "canary.sha256"),
        (|m| m["training"]["instances"]["file"] = "a/b".into(), "training.instances.file"),
    ];
    for (change, named) in cases {
        let folder = copied();
        change_manifest(&folder, change);
        let message = error(&folder).to_string();
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn a_manifest_that_does_not_parse_is_refused_with_line_and_column() {
    let folder = copied();
    let path = folder.path().join(MANIFEST);
    let text = fs::read_to_string(&path).unwrap();
    for (old, new) in [
        ("kind: viewpoint_dependent", "kind: [viewpoint_dependent"),
        ("kind: viewpoint_dependent", "kind: viewpoint_dependent\nkind: embedding"),
        ("measurement: 6", "measurement: .nan"),
        ("measurement: 6", "measurement: six"),
    ] {
        assert!(text.contains(old));
        fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let error = error(&folder);
        let ModelError::Yaml { message, .. } = &error else { panic!("{error}") };
        assert!(message.contains("model.yaml:"), "{message}");
    }
}

#[test]
fn a_model_of_another_kind_is_refused_by_a_use_that_needs_this_one() {
    let refused = PredictiveModel::load(&tiny_model()).unwrap_err();
    let ModelError::Kind { got, expected, .. } = refused else { panic!("{refused}") };
    assert_eq!((got, expected), (Kind::ViewpointDependent, Kind::ViewpointPredictive));
    assert!(matches!(EmbeddingModel::load(&tiny_model()), Err(ModelError::Kind { .. })));
}

#[test]
fn a_list_of_instances_that_cannot_be_read_is_refused() {
    let folder = copied();
    let list = "0123456789abcdef\n0123\n";
    fs::write(folder.path().join(INSTANCE_LIST), list).unwrap();
    assert!(matches!(error(&folder), ModelError::Hash { .. }));
    change_manifest(&folder, |manifest| {
        manifest["training"]["instances"]["sha256"] = sha256(list.as_bytes()).into();
    });
    assert!(matches!(error(&folder), ModelError::Manifest { field, .. } if field == "line 2"));
}

#[cfg(unix)]
#[test]
fn a_device_is_not_read() {
    let folder = copied();
    let path = folder.path().join("encoder.onnx");
    fs::remove_file(&path).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
    assert!(matches!(error(&folder), ModelError::NotAFile { .. }));
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
fn node(operator: &str, inputs: &[&str], output: &str) -> NodeProto {
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
        dims: vec![16384, 1],
        data_type: 1,
        raw_data: vec![0; 4 * 16384],
        ..TensorProto::default()
    };
    let row = TensorProto { name: "row".into(), dims: vec![1, 16384], ..column.clone() };
    let with = |nodes: &[NodeProto]| {
        let (column, row) = (column.clone(), row.clone());
        changed(Role::Measurement, move |model| {
            let graph = model.graph.as_mut().unwrap();
            graph.initializer.extend([column, row]);
            graph.node.splice(0..0, nodes.iter().cloned());
        })
    };
    let product = [node("Mul", &["column", "row"], "made")];
    let sum_with_turned = [node("Transpose", &["row"], "turned"), node("Add", &["turned", "row"], "made")];
    let repeated = |operator: &str, inputs: &[&str]| -> Vec<_> {
        (0..9000).map(|i| node(operator, inputs, &format!("made{i}"))).collect()
    };
    let (one_by_one, dot_products) = (repeated("Exp", &["row"]), repeated("MatMul", &["row", "column"]));
    let gathered = [node("Gather", &["column", "row"], "made")];
    let product_of_matrices = [node("MatMul", &["column", "row"], "made")];
    let padded = [node("Pad", &["row", "column"], "made")];
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
fn derivatives_of_something_else_are_noticed_though_the_canary_has_them() {
    for (output, index) in [("measurement", 0), ("d_latent", 1), ("d_conditioning", 2)] {
        let folder = copied();
        let graph = change_graph(&folder, Role::DecoderJacobian, |model| {
            let nodes = &mut model.graph.as_mut().unwrap().node;
            for name in nodes.iter_mut().flat_map(|node| node.input.iter_mut().chain(&mut node.output)) {
                if name == output {
                    *name = "right".into();
                }
            }
            nodes.push(NodeProto { name: "negated".into(), ..node("Neg", &["right"], output) });
        });
        let path = folder.path().join(CANARY);
        let mut canary: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        for case in canary["cases"].as_array_mut().unwrap() {
            if case["role"] == "decoder_jacobian" {
                for number in case["outputs"][index].as_array_mut().unwrap() {
                    *number = (-number.as_f64().unwrap()).into();
                }
            }
        }
        let canary = canary.to_string();
        fs::write(&path, &canary).unwrap();
        change_manifest(&folder, |manifest| {
            manifest["canary"]["sha256"] = sha256(canary.as_bytes()).into();
            manifest["graphs"]["decoder_jacobian"]["sha256"] = sha256(&graph).into();
        });
        let told = error(&folder);
        assert!(matches!(&told, ModelError::Derivatives { output: named, .. } if named == output), "{told}");
    }
}

#[test]
fn a_canary_cannot_allow_everything() {
    let folder = copied();
    let path = folder.path().join(CANARY);
    let lax = fs::read_to_string(&path).unwrap().replacen("\"tolerance\":0.0001", "\"tolerance\":1e9", 1);
    fs::write(&path, &lax).unwrap();
    assert!(matches!(error(&folder), ModelError::Hash { .. }));
    change_manifest(&folder, |manifest| {
        manifest["canary"]["sha256"] = sha256(lax.as_bytes()).into();
    });
    assert!(matches!(error(&folder), ModelError::Manifest { field, .. } if field == "tolerance"));
}

#[test]
fn any_damaged_byte_is_noticed() {
    for file in files() {
        let whole = fs::read(tiny_model().join(&file)).unwrap();
        // The manifest says what is right; a digit changed in it can be another valid manifest.
        for part in (0..if file == MANIFEST { 0 } else { 6 }).map(|i| (i * 7919 + 13) % whole.len()) {
            let folder = copied();
            let mut bytes = whole.clone();
            bytes[part] ^= 0x15;
            fs::write(folder.path().join(&file), bytes).unwrap();
            assert!(ViewpointModel::load(folder.path()).is_err(), "{file} at {part}");
        }
    }
}

/// Foreign ONNX files, where the workspace has them beside it.
#[test]
fn foreign_models_are_refused() {
    let shared = std::env::var_os("VANTAGE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let found = onnx_files(&shared.join("data/onnx"));
    if found.is_empty() {
        println!("skipped: no ONNX files in {:?}; set VANTAGE_SHARED", shared.join("data/onnx"));
        return;
    }
    for path in found {
        let folder = copied();
        fs::copy(&path, folder.path().join("encoder.onnx")).unwrap();
        let error = error(&folder);
        assert!(matches!(error, ModelError::Graph { .. }), "{path:?}: {error}");
    }
}

fn onnx_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files = Vec::new();
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            files.extend(onnx_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "onnx") {
            files.push(path);
        }
    }
    files
}
