//! Folders that must be refused, each for the right reason.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod graphs;
#[path = "../support/mod.rs"]
mod support;

use graphs::node;
use prost::Message;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use support::{tiny_model, viewpoint_model};
use tempfile::TempDir;
use tract_onnx::pb::{ModelProto, NodeProto};
use vantage_learn::{
    CANARY, GraphError, INSTANCE_LIST, Kind, LARGEST_FILE, MANIFEST, Model, ModelError, Role,
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
    Model::load(folder.path()).unwrap_err()
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
    viewpoint_model(copied().path());
}

#[test]
fn any_missing_file_is_named() {
    for file in files() {
        let folder = copied();
        fs::remove_file(folder.path().join(&file)).unwrap();
        let error = error(&folder);
        assert!(matches!(&error, ModelError::Read { path, .. } if path.ends_with(&file)), "{error}");
    }
    assert!(matches!(Model::load(Path::new("no/such/folder")), Err(ModelError::Read { .. })));
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
    let cases: [(Change, &str); 26] = [
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
        (|m| remove(m, "measurement"), "measurement is missing, expected 1 to 65536"),
        (|m| m["measurement"] = 0.into(), "measurement is 0, expected 1 to 65536"),
        (
            |m| m["residual"]["sqrt_information"][0][0] = 1e308.into(),
            "residual.sqrt_information[0][0] is 1e308",
        ),
        (|m| m["residual"]["sqrt_information"][5][5] = 1e-320.into(), "residual.sqrt_information[5][5]"),
        (|m| m["residual"]["sqrt_information"][0][5] = (-1e308).into(), "expected -1e9 to 1e9"),
        (|m| m["residual"]["sqrt_information"][5][0] = 0.1.into(), "expected 0, below the diagonal"),
        (|m| m["latent"]["dimension"] = 31.into(), "latent.steerable"),
        (|m| m["latent"]["steerable"]["invariant"] = 11.into(), "is invariant 11 and pairs_per_harmonic 2"),
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
fn a_canary_of_a_graph_that_the_manifest_leaves_out_is_named() {
    let folder = copied();
    change_manifest(&folder, |manifest| remove(&mut manifest["graphs"], "image"));
    let error = error(&folder).to_string();
    assert!(
        error.contains("canary.json") && error.contains("cases is one of image, expected only"),
        "{error}"
    );
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
            assert!(Model::load(folder.path()).is_err(), "{file} at {part}");
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
        let told = format!("SKIPPED: no ONNX files in {:?}; set VANTAGE_SHARED\n", shared.join("data/onnx"));
        let _ = std::io::Write::write_all(&mut std::io::stderr(), told.as_bytes());
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
