//! A trained model as the estimator sees it.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod support;

use approx::assert_relative_eq;
use nalgebra::{DMatrix, DVector};
use support::{tiny_model, validation_views, viewpoint_model};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};
use vantage_learn::{
    CANARY, Canary, CanaryCase, DecoderLastLayer, GraphError, Kind, Model, ModelError, Role, Viewing,
    ViewpointModel,
};
use vantage_model::{LastLayer, LatentGaussian, ObservationModel};

fn model() -> ViewpointModel {
    viewpoint_model(&tiny_model())
}

fn canary() -> Vec<CanaryCase> {
    let json = std::fs::read_to_string(tiny_model().join(CANARY)).unwrap();
    serde_json::from_str::<Canary>(&json).unwrap().cases
}

fn vector(numbers: &[f32]) -> DVector<f64> {
    DVector::from_iterator(numbers.len(), numbers.iter().map(|&number| f64::from(number)))
}

fn conditioning(numbers: &[f32]) -> [f64; CONDITIONING] {
    std::array::from_fn(|i| f64::from(numbers[i]))
}

/// A latent and a viewpoint's conditioning that the model has use for.
fn state(model: &ViewpointModel) -> (DVector<f64>, Viewpoint) {
    let views = validation_views().views;
    let factors: Vec<_> =
        views[..3].iter().map(|view| model.encode(&view.crop, &view.viewpoint).unwrap()).collect();
    (LatentGaussian::posterior(model.latent().dimension, &factors).mean, views[5].viewpoint)
}

#[test]
fn tract_computes_what_the_trainer_computed() {
    let model = model();
    let close = |got: &DVector<f64>, expected: &[f32]| {
        assert_relative_eq!(*got, vector(expected), epsilon = 1e-5, max_relative = 1e-5);
    };
    let mut replayed = Vec::new();
    for CanaryCase { role, inputs, outputs } in canary() {
        match role {
            Role::Measurement => close(&model.measure(&Crop::from_chw(&inputs[0])).unwrap(), &outputs[0]),
            Role::Decoder => {
                close(&model.decode(&vector(&inputs[0]), &conditioning(&inputs[1])).unwrap(), &outputs[0]);
            }
            Role::DecoderJacobian => {
                let at = model.decode_linear(&vector(&inputs[0]), &conditioning(&inputs[1])).unwrap();
                close(&at.mean, &outputs[0]);
                let rows = |matrix: &DMatrix<f64>| DVector::from_column_slice(matrix.transpose().as_slice());
                close(&rows(&at.d_latent), &outputs[1]);
                close(&rows(at.d_viewpoint.by_coordinates()), &outputs[2]);
            }
            Role::Image => {
                let got = model.decode_image(&vector(&inputs[0]), &conditioning(&inputs[1])).unwrap();
                let planes = got.to_chw();
                assert!(planes.iter().zip(&outputs[0]).all(|(got, expected)| (got - expected).abs() < 0.003));
            }
            _ => assert_eq!(role, Role::Encoder),
        }
        replayed.push(role);
    }
    replayed.dedup();
    assert!(Kind::ViewpointDependent.roles().iter().all(|(role, _)| replayed.contains(role)));
}

#[test]
fn encoding_a_crop_gives_the_canary_and_a_shared_variance_in_each_pair() {
    let model = model();
    let layout = model.latent().steerable.unwrap();
    let (first, pairs) = (layout.invariant, layout.pairs());
    let view = &support::training_views().views[0];
    let case = canary().into_iter().find(|case| case.role == Role::Encoder).unwrap();
    let factor = model.encode(&view.crop, &view.viewpoint).unwrap();
    assert_relative_eq!(factor.mean, vector(&case.outputs[0]), epsilon = 1e-5, max_relative = 1e-5);
    let log_variance = factor.variance.map(f64::ln);
    assert_relative_eq!(log_variance, vector(&case.outputs[1]), epsilon = 1e-5, max_relative = 1e-5);
    assert_eq!(factor.variance.rows(first, pairs), factor.variance.rows(first + pairs, pairs));
}

#[test]
fn the_jacobian_graph_matches_central_differences_of_the_decoder() {
    let model = model();
    let (latent, viewpoint) = state(&model);
    let x = viewpoint.conditioning();
    let at = model.decode_linear(&latent, &x).unwrap();
    assert_relative_eq!(at.mean, model.decode(&latent, &x).unwrap(), epsilon = 1e-6);
    let numbers = latent.len() + CONDITIONING;
    let jacobian = DMatrix::from_fn(at.mean.len(), numbers, |row, column| {
        if column < latent.len() {
            at.d_latent[(row, column)]
        } else {
            at.d_viewpoint.by_coordinates()[(row, column - latent.len())]
        }
    });
    const STEP: f64 = 1e-3;
    for column in 0..numbers {
        let moved = |step: f64| {
            let (mut latent, mut x) = (latent.clone(), x);
            match column.checked_sub(latent.len()) {
                None => latent[column] += step,
                Some(index) => x[index] += step,
            }
            model.decode(&latent, &x).unwrap()
        };
        let difference = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
        let error = (&difference - jacobian.column(column)).amax();
        let scale = jacobian.amax();
        assert!(error < 2e-3 * scale, "column {column}: {error} of {scale}");
    }
}

#[test]
fn turning_the_viewpoint_turns_what_is_encoded() {
    let model = model();
    let view = &validation_views().views[4];
    let here = model.encode(&view.crop, &view.viewpoint).unwrap();
    for angle in [0.3, 2.0, -2.7] {
        let there = model.encode(&view.crop, &view.viewpoint.turned(angle)).unwrap();
        let turned = model.latent().steerable.unwrap().turned(&here.mean, angle);
        assert!((&turned - &here.mean).norm() > 0.05);
        assert_relative_eq!(there.mean, turned, epsilon = 1e-5);
        assert_relative_eq!(there.variance, here.variance, max_relative = 1e-5);
    }
}

#[test]
fn an_encoding_does_not_depend_on_what_was_encoded_before() {
    let model = model();
    let views = &validation_views().views[..5];
    for angle in [0.0, 0.4, 2.0] {
        for view in views {
            let from = view.viewpoint.turned(angle);
            let alone = viewpoint_model(&tiny_model()).encode(&view.crop, &from).unwrap();
            assert_eq!(model.encode(&view.crop, &from).unwrap(), alone, "{angle}");
        }
    }
}

#[test]
fn noise_latent_and_identity_are_told() {
    let model = model();
    assert_eq!(model.noise().dimension(), 6);
    assert_eq!(model.measurement_dim(), 6);
    assert_eq!(model.latent().dimension, 30);
    let loaded = Model::load(&tiny_model()).unwrap();
    assert_eq!(loaded.hash().len(), 64);
    let manifest = loaded.manifest();
    let details = manifest.training.details.as_ref().unwrap();
    assert_eq!((details.instances, details.views), (12, 96));
    let (training, validation) = (support::training_views(), validation_views());
    let shown = training.instances.iter().chain(&validation.instances).map(|instance| instance.id);
    assert_eq!(*loaded.training_instances(), shown.collect());
    assert_eq!(manifest.training.data_hash, vantage_learn::view_set_hash(&support::training_views()));
    assert_eq!(manifest.training.provenance["scene"], "a scene");
}

#[test]
fn the_noise_whitens_the_residuals_it_was_fitted_to() {
    let model = model();
    let noise = model.noise();
    let set = validation_views();
    let mut squares = Vec::new();
    for instance in set.views.chunks(8) {
        let encoded = |view: &vantage_dataset::View| model.encode(&view.crop, &view.viewpoint).unwrap();
        let factors: Vec<_> = instance[..3].iter().map(encoded).collect();
        let latent = LatentGaussian::posterior(30, &factors).mean;
        for view in &instance[3..] {
            let expected = model.predict(&latent, &view.viewpoint).unwrap();
            let residual = model.measure(&view.crop).unwrap() - expected;
            squares.push((noise.sqrt_information() * residual).norm_squared());
        }
    }
    squares.sort_by(f64::total_cmp);
    let median = squares[squares.len() / 2];
    assert!(
        (2.0..15.0).contains(&median),
        "median of the whitened squares {median}, {}",
        noise.degrees_of_freedom()
    );
}

#[test]
fn a_latent_of_the_wrong_length_is_an_error() {
    let error = model().decode(&DVector::zeros(29), &[0.0; CONDITIONING]).unwrap_err();
    let ModelError::Run { role: Role::Decoder, source: GraphError::Input { got: 29, expected: 30, .. } } =
        error
    else {
        panic!("{error}");
    };
}

#[test]
fn states_out_of_all_range_are_errors() {
    let model = model();
    for value in [f64::NAN, f64::INFINITY, f64::MAX, -3e38, 1.1e6] {
        let error = model.decode(&DVector::from_element(30, value), &[1.0; CONDITIONING]).unwrap_err();
        assert!(matches!(error, ModelError::Run { source: GraphError::InputRange { .. }, .. }), "{error}");
    }
    model.decode(&DVector::from_element(30, 1e6), &[1.0; CONDITIONING]).unwrap();
}

#[test]
fn runs_beside_each_other_have_the_same_bits() {
    let model = model();
    let (latent, viewpoint) = state(&model);
    let x = viewpoint.conditioning();
    let alone = model.decode_linear(&latent, &x).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..50 {
                    assert_eq!(model.decode_linear(&latent, &x).unwrap(), alone);
                }
            });
        }
    });
}

#[test]
fn a_changed_last_layer_changes_predictions_by_the_change_times_the_features() {
    let folder = tiny_model();
    let model = viewpoint_model(&folder);
    let (latent, viewpoint) = state(&model);
    let layer = DecoderLastLayer::load(&model, &folder).unwrap();
    let phi = layer.features(&latent, &viewpoint).unwrap();
    assert_eq!(phi[phi.len() - 1], 1.0, "of the bias");
    let before = model.predict(&latent, &viewpoint).unwrap();
    let zero = DMatrix::zeros(before.len(), phi.len());
    let same = layer.changed(&zero).unwrap();
    assert_eq!(same.predict(&latent, &viewpoint).unwrap(), before);
    assert_eq!(same.linearize(&latent, &viewpoint).unwrap(), model.linearize(&latent, &viewpoint).unwrap());

    let change = DMatrix::from_fn(before.len(), phi.len(), |i, j| 0.05 * ((3 * i + 7 * j) % 11) as f64 - 0.2);
    let changed = layer.changed(&change).unwrap();
    let expected = &before + &change * &phi;
    assert_relative_eq!(changed.predict(&latent, &viewpoint).unwrap(), expected, epsilon = 1e-4);
    let at = changed.linearize(&latent, &viewpoint).unwrap();
    assert_relative_eq!(at.mean, expected, epsilon = 1e-4);
    let step = 1e-2;
    for number in [0, latent.len() - 1] {
        let moved = |by: f64| {
            let mut latent = latent.clone();
            latent[number] += by;
            changed.predict(&latent, &viewpoint).unwrap()
        };
        let numeric = (moved(step) - moved(-step)) / (2.0 * step);
        assert_relative_eq!(at.d_latent.column(number).into_owned(), numeric, epsilon = 5e-3);
    }
    assert!(layer.changed(&DMatrix::zeros(before.len(), 3)).is_err());
}

/// Minted anew with the committed model; a change by anything else is a fault.
#[cfg(target_arch = "x86_64")]
#[test]
fn the_committed_model_has_the_bits_that_it_had() {
    use std::arch::is_x86_feature_detected as detected;

    if !(detected!("avx2") && detected!("fma") && detected!("f16c")) {
        return println!("skipped: other kernels than those of AVX2");
    }
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/objects");
    let model = viewpoint_model(&folder);
    let mut crop = Crop::black();
    crop.0.iter_mut().enumerate().for_each(|(i, byte)| *byte = (i * i % 251) as u8);
    let viewpoint =
        Viewpoint { direction: nalgebra::Vector3::new(0.6, 0.64, 0.48), roll: 0.1, log_distance: 0.5 };
    let latent = model.encode(&crop, &viewpoint).unwrap();
    let x = viewpoint.conditioning();
    let at = model.decode_linear(&latent.mean, &x).unwrap();
    let measurement = model.measure(&crop).unwrap();
    let predicted = model.decode(&latent.mean, &x).unwrap();
    let vectors = [&latent.mean, &latent.variance, &measurement, &predicted, &at.mean];
    let mut hash = blake3::Hasher::new();
    for number in vectors.into_iter().flatten().chain(&at.d_latent).chain(at.d_viewpoint.by_coordinates()) {
        hash.update(&number.to_le_bytes());
    }
    hash.update(&*model.decode_image(&latent.mean, &x).unwrap().0);
    assert_eq!(
        hash.finalize().to_hex().as_str(),
        "fff5bd4491d2acd1a1491aceabc5e7099b9476cf04962fe66d302c7b9e359368"
    );
}

#[cfg(target_arch = "x86_64")]
#[test]
fn the_environment_has_no_say_in_the_instructions_that_models_run_by() {
    use tract_onnx::tract_core::knobs;
    use tract_onnx::tract_core::tract_linalg::{isa, knobs::TRACT_CPU_ISA};

    model();
    let fast = std::arch::is_x86_feature_detected!("avxvnni");
    let left_out = if fast { "-avx512fp16" } else { "-avx512f,-avx512fp16" };
    assert_eq!(TRACT_CPU_ISA.get().as_deref(), Some(left_out));
    let taken = isa::native().has(isa::Isa::X86_64Avx512f);
    assert_eq!(taken, fast && std::arch::is_x86_feature_detected!("avx512f"));
    for way in [
        "AMX_BF16",
        "AVGPOOL_SEPARABLE",
        "DISABLE_DEPTHWISE_DECONV",
        "DISABLE_DIRECT_SPATIAL",
        "ENABLE_BLOCKED_CONV",
    ] {
        let knob = knobs::all().into_iter().find(|knob| knob.name == format!("TRACT_{way}")).unwrap();
        assert_eq!((knob.current)(), "false", "{way}");
    }
}
