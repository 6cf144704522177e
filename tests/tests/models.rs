//! `bench models`: what a model folder is, or why it is none.

use std::fs;
use vantage_tests::{Finished, SmallScene, bench, root};

#[test]
fn the_committed_model_is_described() {
    let told = Finished::of(bench().args(["models", "models/objects"]));
    told.expect(0, &[]);
    for words in [
        "viewpoint_dependent",
        "128 numbers: 28 that do not turn, 50 pairs that do",
        "azimuth_harmonics",
        "decoder_jacobian",
        "d_conditioning [32, 14]",
        "127984 views of 8000 instances",
    ] {
        assert!(told.stdout.contains(words), "{words:?} is not in {}", told.stdout);
    }
}

#[test]
fn faults_are_told_with_their_place_and_end_with_5() {
    let scene = SmallScene::new(&[]);
    let models = |name: &str| Finished::of(bench().arg("models").arg(scene.path(name)));
    models("missing").expect(5, &["model.yaml", "docs/models.md"]);
    Finished::of(bench().arg("models")).expect(2, &["DIR"]);

    let manifest = fs::read_to_string(root().join("models/objects/model.yaml")).expect("the committed model");
    for (name, old, new, words) in [
        ("key", "measurement: 32", "mesurement: 32", ["model.yaml:", "mesurement"]),
        ("type", "dimension: 128", "dimension: many", ["model.yaml:", "dimension"]),
        (
            "convention",
            "azimuth_harmonics",
            "camera_motion",
            ["conditioning is camera_motion", "azimuth_harmonics"],
        ),
        ("escape", "file: encoder.onnx", "file: ../encoder.onnx", ["graphs.encoder.file", "../encoder.onnx"]),
        ("version", "version: 2", "version: 1", ["version 1", "version 2"]),
    ] {
        assert!(manifest.contains(old), "{old}");
        fs::create_dir(scene.path(name)).expect("a folder");
        fs::write(scene.path(name).join("model.yaml"), manifest.replacen(old, new, 1)).expect("a manifest");
        models(name).expect(5, &words);
    }
}
