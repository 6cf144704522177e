//! Model folders: a model or an error, whatever the bytes of one of its files.
//!
//! The first byte says which file of a tiny model the others take the place of, in the order of their names.
//! The manifest's hashes are set right, so that no reader behind them is shielded.

#![no_main]

#[expect(dead_code, reason = "shared with tests that build larger graphs")]
#[path = "../../learn/tests/support/graphs.rs"]
mod graphs;

use graphs::{add_node, add_weight, file, graph};
use libfuzzer_sys::fuzz_target;
use std::collections::BTreeMap;
use std::fs;
use std::sync::LazyLock;
use tract_onnx::pb::GraphProto;
use vantage_learn::{
    CANARY, Canary, CanaryCase, Convention, FORMAT, FileRecord, GraphRecord, Kind, Latent, MANIFEST,
    Manifest, Model, ModelError, ResidualNoise, Role, Sizes, TensorSpec, TrainingRecord, VERSION,
};

const KIND: Kind = Kind::ViewpointDependent;
const CONVENTION: Convention = Convention::AzimuthHarmonics;
/// Numbers in the latent and in the measurement: a crop's mean colour.
const COLOUR: usize = 3;
const OPSET: i64 = 17;
const INSTANCES: &str = "training_instances.txt";

static FILES: LazyLock<BTreeMap<String, Vec<u8>>> = LazyLock::new(|| {
    let files = tiny_model();
    load(&files).expect("a model");
    files
});

fuzz_target!(init: { LazyLock::force(&FILES); }, |bytes: &[u8]| {
    let Some((&which, bytes)) = bytes.split_first() else { return };
    let mut files = FILES.clone();
    let (name, replaced) = files.iter_mut().nth(usize::from(which) % FILES.len()).expect("a file");
    *replaced = bytes.to_vec();
    if name != MANIFEST {
        files.insert(MANIFEST.into(), manifest(&files));
    }
    let _ = load(&files);
});

fn load(files: &BTreeMap<String, Vec<u8>>) -> Result<Model, ModelError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    Model::load(folder.path())
}

fn sizes() -> Sizes {
    Sizes { latent: COLOUR, measurement: COLOUR, conditioning: CONVENTION.numbers() }
}

/// Latent and measurement are the mean colour of the crop, from whatever viewpoint.
fn tiny_model() -> BTreeMap<String, Vec<u8>> {
    let of_crop = |graph: &mut GraphProto, output: &str| {
        add_node(graph, "GlobalAveragePool", &["crop"], "colour");
        add_node(graph, "Flatten", &["colour"], output);
    };
    let conditioning = CONVENTION.numbers();
    let graphs: [(Role, &dyn Fn(&mut GraphProto)); 4] = [
        (Role::Encoder, &|graph| {
            of_crop(graph, "mean");
            add_node(graph, "Neg", &["mean"], "log_variance");
        }),
        (Role::Measurement, &|graph| of_crop(graph, "measurement")),
        (Role::Decoder, &|graph| add_node(graph, "Identity", &["latent"], "measurement")),
        (Role::DecoderJacobian, &|graph| {
            add_node(graph, "Identity", &["latent"], "measurement");
            add_weight(graph, "identity", &[COLOUR, COLOUR], &[1., 0., 0., 0., 1., 0., 0., 0., 1.]);
            add_node(graph, "Identity", &["identity"], "d_latent");
            add_weight(graph, "zeros", &[COLOUR, conditioning], &vec![0.0; COLOUR * conditioning]);
            add_node(graph, "Identity", &["zeros"], "d_conditioning");
        }),
    ];
    let mut files = BTreeMap::new();
    let mut canary = Canary { tolerance: 1e-4, cases: Vec::new() };
    for (role, build) in graphs {
        let signature = KIND.signature(role, sizes()).expect("a role of this kind");
        let mut graph = graph(&signature);
        build(&mut graph);
        files.insert(role.file(), file(graph, OPSET));
        let zeros =
            |tensors: &[TensorSpec]| tensors.iter().map(|t| vec![0.0; t.volume()]).collect::<Vec<_>>();
        let (inputs, mut outputs) = (zeros(&signature.inputs), zeros(&signature.outputs));
        if role == Role::DecoderJacobian {
            outputs[1] = vec![1., 0., 0., 0., 1., 0., 0., 0., 1.];
        }
        canary.cases.push(CanaryCase { role, inputs, outputs });
    }
    files.insert(CANARY.into(), serde_json::to_vec(&canary).expect("JSON"));
    files.insert(INSTANCES.into(), b"00000000000000ff\n".to_vec());
    files.insert(MANIFEST.into(), manifest(&files));
    files
}

/// The manifest of the other files.
fn manifest(files: &BTreeMap<String, Vec<u8>>) -> Vec<u8> {
    let record = |name: &str| FileRecord::new(name, &files[name]);
    let graph = |&(role, _): &(Role, bool)| {
        let (name, signature) = (role.file(), KIND.signature(role, sizes())?);
        Some((role, GraphRecord::new(&name, files.get(&name)?, &signature)))
    };
    let row = |i: usize| (0..COLOUR).map(|j| f64::from(u8::from(i == j))).collect();
    let manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        kind: KIND,
        latent: Latent { dimension: COLOUR, steerable: None },
        measurement: Some(COLOUR),
        conditioning: Some(CONVENTION),
        graphs: KIND.roles().iter().filter_map(graph).collect(),
        residual: Some(ResidualNoise {
            degrees_of_freedom: 5.0,
            sqrt_information: (0..COLOUR).map(row).collect(),
            residuals: 100,
        }),
        training: TrainingRecord {
            origin: "fuzzing".into(),
            data_hash: "none".into(),
            instances: record(INSTANCES),
            provenance: BTreeMap::new(),
            details: None,
        },
        canary: record(CANARY),
    };
    // JSON is YAML.
    serde_json::to_vec(&manifest).expect("JSON")
}
