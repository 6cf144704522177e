//! Models that another program wrote: all kinds, with no more graphs than they must have.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

#[path = "support/graphs.rs"]
mod graphs;
mod support;

use approx::assert_relative_eq;
use graphs::{add_constant, add_half_weight, add_node, add_weight, file, graph};
use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::Path;
use support::{tiny_model, validation_views, viewpoint_model};
use tempfile::TempDir;
use tract_onnx::pb::GraphProto;
use vantage_dataset::crop::CROP_BYTES;
use vantage_dataset::{Crop, InstanceId};
use vantage_learn::{
    Convention, GraphError, Kind, MANIFEST, Model, ModelError, Role, Sizes, object_centred_change,
};
use vantage_model::ObservationModel;

const LATENT: usize = 4;
const MEASUREMENT: usize = 3;
const CHANGE: usize = 18;
const SIZES: Sizes = Sizes { latent: LATENT, measurement: MEASUREMENT, conditioning: CHANGE };

/// Numbers that half precision holds exactly.
fn weights(count: usize, step: f32) -> Vec<f32> {
    (0..count).map(|index| ((index as f32 * step).sin() * 64.0).round() / 128.0).collect()
}

/// A linear layer of the flattened crop, `[1, outputs]`.
fn of_crop(graph: &mut GraphProto, output: &str, outputs: usize, step: f32) {
    if !graph.node.iter().any(|node| node.op_type == "Flatten") {
        add_node(graph, "Flatten", &["crop"], "flat");
    }
    let weight = format!("{output}.weight");
    add_weight(graph, &weight, &[CROP_BYTES, outputs], &crop_weights(outputs, step));
    add_node(graph, "MatMul", &["flat", &weight], output);
}

fn crop_weights(outputs: usize, step: f32) -> Vec<f32> {
    weights(CROP_BYTES * outputs, step).into_iter().map(|weight| weight / 256.0).collect()
}

fn linear(planes: &[f32], outputs: usize, step: f32) -> Vec<f32> {
    let weights = crop_weights(outputs, step);
    let column = |output| planes.iter().enumerate().map(move |(row, &x)| (row * outputs + output, x));
    (0..outputs).map(|output| column(output).map(|(index, x)| x * weights[index]).sum()).collect()
}

fn crop() -> Crop {
    let mut crop = Crop::black();
    for (index, byte) in crop.0.iter_mut().enumerate() {
        *byte = (index * 37 % 251) as u8;
    }
    crop
}

/// `tanh(e E + m M + change C)`.
fn predicted(latent: &[f64], measurement: &[f64], change: &[f64]) -> DVector<f64> {
    let matrix = |rows, step| {
        DMatrix::from_row_iterator(
            rows,
            MEASUREMENT,
            weights(rows * MEASUREMENT, step).into_iter().map(f64::from),
        )
    };
    let vector = DVector::from_column_slice;
    let sum = matrix(LATENT, 0.7).tr_mul(&vector(latent))
        + matrix(MEASUREMENT, 1.1).tr_mul(&vector(measurement))
        + matrix(CHANGE, 0.3).tr_mul(&vector(change));
    sum.map(f64::tanh)
}

fn narrowed(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|&number| number as f32).collect()
}

/// A folder of graphs with a canary of one case each, and its manifest.
struct Folder {
    folder: TempDir,
    kind: Kind,
    graphs: serde_json::Map<String, Value>,
    cases: Vec<Value>,
}

impl Folder {
    fn new(kind: Kind) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder, kind, graphs: serde_json::Map::new(), cases: Vec::new() }
    }

    fn add(
        &mut self,
        role: Role,
        opset: i64,
        build: impl FnOnce(&mut GraphProto),
        inputs: &[&[f32]],
        outputs: &[Vec<f32>],
    ) {
        let signature = self.kind.signature(role, SIZES).unwrap();
        let mut graph = graph(&signature);
        build(&mut graph);
        let mut record = self.write(&role.file(), &file(graph, opset));
        for (key, side) in [("inputs", &signature.inputs), ("outputs", &signature.outputs)] {
            record[key] = side
                .iter()
                .map(|t| (t.name.clone(), json!(t.shape)))
                .collect::<serde_json::Map<_, _>>()
                .into();
        }
        self.graphs.insert(role.name().into(), record);
        self.cases.push(json!({ "role": role, "inputs": inputs, "outputs": outputs }));
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Value {
        fs::write(self.folder.path().join(name), bytes).unwrap();
        let sha256: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        json!({ "file": name, "sha256": sha256 })
    }

    fn finish(self, extra: Value) -> TempDir {
        let canary = serde_json::to_vec(&json!({ "tolerance": 1e-4, "cases": self.cases })).unwrap();
        let mut manifest = json!({
            "format": "vantage model",
            "version": 2,
            "kind": self.kind,
            "latent": { "dimension": LATENT },
            "graphs": self.graphs,
            "training": {
                "origin": "a test",
                "data_hash": "none",
                "instances": self.write("seen.txt", b"00000000000000ff\n"),
            },
            "canary": self.write("cases.json", &canary),
        });
        manifest.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        fs::write(self.folder.path().join(MANIFEST), serde_json::to_vec(&manifest).unwrap()).unwrap();
        self.folder
    }
}

fn predictive() -> TempDir {
    let mut folder = Folder::new(Kind::ViewpointPredictive);
    let planes = crop().to_chw();
    let (mean, log_variance) = (linear(&planes, LATENT, 0.9), linear(&planes, LATENT, 0.2));
    let encoder = |graph: &mut GraphProto| {
        of_crop(graph, "mean", LATENT, 0.9);
        of_crop(graph, "log_variance", LATENT, 0.2);
    };
    folder.add(Role::Encoder, 13, encoder, &[&planes], &[mean.clone(), log_variance]);
    let m = linear(&planes, MEASUREMENT, 1.7);
    let measurement = |graph: &mut GraphProto| of_crop(graph, "measurement", MEASUREMENT, 1.7);
    folder.add(Role::Measurement, 17, measurement, &[&planes], std::slice::from_ref(&m));
    let predictor = |graph: &mut GraphProto| {
        add_half_weight(graph, "E", &[LATENT, MEASUREMENT], &weights(LATENT * MEASUREMENT, 0.7));
        add_constant(graph, "M", &[MEASUREMENT, MEASUREMENT], &weights(MEASUREMENT * MEASUREMENT, 1.1));
        add_weight(graph, "C", &[CHANGE, MEASUREMENT], &weights(CHANGE * MEASUREMENT, 0.3));
        add_node(graph, "MatMul", &["latent", "E"], "by_latent");
        add_node(graph, "MatMul", &["measurement", "M"], "by_measurement");
        add_node(graph, "MatMul", &["change", "C"], "by_change");
        add_node(graph, "Add", &["by_latent", "by_measurement"], "by_both");
        add_node(graph, "Add", &["by_both", "by_change"], "sum");
        add_node(graph, "Tanh", &["sum"], "other_measurement");
    };
    let change = [0.25f32; CHANGE];
    let wide = |numbers: &[f32]| numbers.iter().map(|&number| f64::from(number)).collect::<Vec<_>>();
    let other = predicted(&wide(&mean), &wide(&m), &wide(&change));
    folder.add(Role::Predictor, 18, predictor, &[&mean, &m, &change], &[narrowed(other.as_slice())]);
    folder.finish(json!({
        "measurement": MEASUREMENT,
        "conditioning": Convention::ObjectCentredChange,
        "residual": {
            "degrees_of_freedom": 5,
            "sqrt_information": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "residuals": 100,
        },
    }))
}

#[test]
fn a_predictive_model_encodes_measures_predicts_and_is_differentiated() {
    let folder = predictive();
    let loaded = Model::load(folder.path()).unwrap();
    assert_eq!(*loaded.training_instances(), [InstanceId(0xff)].into());
    let Model::ViewpointPredictive(model) = &loaded else { panic!("{loaded:?}") };
    let views = validation_views().views;
    let change = object_centred_change(&views[0].viewpoint, &views[1].viewpoint);
    assert_eq!((model.convention().numbers(), change.len()), (CHANGE, CHANGE));

    let factor = model.encode(&crop()).unwrap();
    let measured = model.measure(&crop()).unwrap();
    assert_eq!((factor.mean.len(), measured.len()), (LATENT, MEASUREMENT));
    assert!(factor.variance.iter().all(|variance| *variance > 0.0));
    let expected = predicted(factor.mean.as_slice(), measured.as_slice(), &change);
    let got = model.predict(&factor.mean, &measured, &change).unwrap();
    assert_relative_eq!(got, expected, epsilon = 1e-6);

    let at = model.linearize(&factor.mean, &measured, &change).unwrap();
    assert_eq!(at.measurement, got);
    for (derivative, rows, step) in
        [(&at.d_latent, LATENT, 0.7), (&at.d_measurement, MEASUREMENT, 1.1), (&at.d_change, CHANGE, 0.3)]
    {
        let weights = weights(rows * MEASUREMENT, step);
        assert_eq!(derivative.shape(), (MEASUREMENT, rows));
        for (row, column) in (0..MEASUREMENT).flat_map(|row| (0..rows).map(move |column| (row, column))) {
            let slope = 1.0 - expected[row] * expected[row];
            let exact = slope * f64::from(weights[column * MEASUREMENT + row]);
            assert_relative_eq!(derivative[(row, column)], exact, epsilon = 1e-4);
        }
    }
    let missing = model.reconstruct(&factor.mean, &measured, &change).unwrap_err();
    assert!(matches!(missing, ModelError::Absent { role: Role::Image }), "{missing}");
    let short = model.predict(&factor.mean, &measured, &change[1..]).unwrap_err();
    assert!(matches!(short, ModelError::Run { source: GraphError::Input { got: 17, .. }, .. }), "{short}");

    let embedded = loaded.embed(&crop(), None).unwrap();
    let posterior = factor.mean.component_div(&factor.variance.map(|variance| 1.0 + variance));
    assert_relative_eq!(DVector::from_vec(embedded), posterior, epsilon = 1e-12);
}

#[test]
fn an_embedding_embeds_and_has_nothing_else() {
    let mut folder = Folder::new(Kind::Embedding);
    let planes = crop().to_chw();
    let mean = linear(&planes, LATENT, 0.4);
    let encoder = |graph: &mut GraphProto| of_crop(graph, "mean", LATENT, 0.4);
    folder.add(Role::Encoder, 18, encoder, &[&planes], std::slice::from_ref(&mean));
    let folder = folder.finish(json!({}));
    let model = Model::load(folder.path()).unwrap();
    let embedded = model.embed(&crop(), None).unwrap();
    assert_relative_eq!(
        DVector::from_vec(embedded).map(|n| n as f32),
        DVector::from_vec(mean),
        epsilon = 1e-5
    );
    model.replay(Role::Encoder).unwrap();
    assert!(matches!(model.replay(Role::Measurement), Err(ModelError::Absent { .. })));
}

/// The trained model of the tests without some of its graphs.
fn without(roles: &[&str], folder: &Path) {
    for entry in fs::read_dir(tiny_model()).unwrap().map(|entry| entry.unwrap()) {
        fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
    }
    let edit = |name: &str, change: &dyn Fn(&mut Value)| {
        let path = folder.join(name);
        let mut value: Value = serde_saphyr::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        change(&mut value);
        fs::write(path, serde_json::to_vec(&value).unwrap()).unwrap();
    };
    edit("canary.json", &|canary| {
        let cases = canary["cases"].as_array_mut().unwrap();
        cases.retain(|case| !roles.contains(&case["role"].as_str().unwrap()));
    });
    let canary = Sha256::digest(fs::read(folder.join("canary.json")).unwrap());
    edit(MANIFEST, &|manifest| {
        manifest["graphs"].as_object_mut().unwrap().retain(|role, _| !roles.contains(&role.as_str()));
        let digits: String = canary.iter().map(|byte| format!("{byte:02x}")).collect();
        manifest["canary"]["sha256"] = digits.into();
    });
}

#[test]
fn without_its_jacobian_a_decoder_is_differentiated_by_central_differences() {
    let folder = tempfile::tempdir().unwrap();
    without(&["decoder_jacobian", "image"], folder.path());
    let (whole, less) = (viewpoint_model(&tiny_model()), viewpoint_model(folder.path()));
    assert!(whole.has(Role::DecoderJacobian) && !less.has(Role::DecoderJacobian));
    for view in validation_views().views.iter().take(3) {
        let latent = whole.encode(&view.crop, &view.viewpoint).unwrap().mean;
        let x = view.viewpoint.conditioning();
        let (exact, near) =
            (whole.decode_linear(&latent, &x).unwrap(), less.decode_linear(&latent, &x).unwrap());
        assert_relative_eq!(near.mean, exact.mean, epsilon = 1e-6);
        for (near, exact) in [
            (&near.d_latent, &exact.d_latent),
            (near.d_viewpoint.by_coordinates(), exact.d_viewpoint.by_coordinates()),
        ] {
            assert!(
                (near - exact).amax() < 1e-3 * exact.amax(),
                "{} of {}",
                (near - exact).amax(),
                exact.amax()
            );
        }
        let missing = less.decode_image(&latent, &x).unwrap_err();
        assert!(matches!(missing, ModelError::Absent { role: Role::Image }), "{missing}");
    }
}

#[test]
fn what_is_embedded_of_a_steerable_latent_does_not_turn() {
    let model = Model::load(&tiny_model()).unwrap();
    let view = &validation_views().views[4];
    let here = DVector::from_vec(model.embed(&view.crop, Some(&view.viewpoint)).unwrap());
    let turned = DVector::from_vec(model.embed(&view.crop, Some(&view.viewpoint.turned(1.3))).unwrap());
    assert_relative_eq!(here, turned, epsilon = 1e-5);
    assert!(here.norm() > 0.05);
    assert!(matches!(model.embed(&view.crop, None), Err(ModelError::NoViewpoint)));
}
