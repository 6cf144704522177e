//! The graphs of a model folder, from trained weights.

mod encoder;
mod jacobian;

use crate::architecture::Architecture;
use crate::latent::LatentLayout;
use crate::onnx::Signature;
use crate::onnx::build::GraphBuilder;
use crate::role::{Kind, Role, Sizes};
use crate::train::network::CLASS_SHARPNESS;
use crate::train::network::weights::{Dense, Weights};
use encoder::{encoder, trunk};
use jacobian::jacobian;
use vantage_dataset::crop::CROP_SIDE;

/// The graphs that are written of a model; a latent that does not turn leaves the Jacobian to differences.
pub(crate) fn roles(architecture: &Architecture) -> Vec<Role> {
    let (decoder, jacobian) = match architecture.kind() {
        Kind::ViewpointDependent => (Role::Decoder, Role::DecoderJacobian),
        Kind::ViewpointPredictive => (Role::Predictor, Role::PredictorJacobian),
        Kind::Embedding => return vec![Role::Encoder],
    };
    let jacobian = (architecture.latent.pairs() > 0).then_some(jacobian);
    let always = [Role::Encoder, Role::Measurement, decoder];
    always.into_iter().chain(jacobian).chain([Role::Image]).collect()
}

/// The tensors of a role.
pub(crate) fn signature(role: Role, architecture: &Architecture) -> Signature {
    let (latent, measurement) = (architecture.latent.dimension(), architecture.measurement);
    let sizes = Sizes { latent, measurement, conditioning: architecture.conditioning() };
    architecture.kind().signature(role, sizes).expect("a role of this kind")
}

/// The ONNX bytes of a role.
pub(crate) fn graph(role: Role, weights: &Weights) -> Vec<u8> {
    let mut b = GraphBuilder::new(role.name(), &signature(role, &weights.architecture));
    match role {
        Role::Measurement => {
            let features = trunk(&mut b, weights);
            dense(&mut b, "measurement", &features, &weights.measurement);
        }
        Role::Encoder => encoder(&mut b, weights),
        Role::Decoder | Role::Predictor => {
            let hidden = decoder(&mut b, weights).hidden;
            dense(&mut b, predicted(&weights.architecture), &hidden, &weights.decoded_measurement);
        }
        Role::DecoderJacobian | Role::PredictorJacobian => jacobian(&mut b, weights),
        Role::Image => {
            let hidden = decoder(&mut b, weights).hidden;
            let coefficients = dense(&mut b, "coefficients", &hidden, &weights.decoded_image);
            let flat = dense(&mut b, "flat_crop", &coefficients, &weights.basis);
            let shape = b.sizes("crop.shape", &[1, 3, CROP_SIDE, CROP_SIDE]);
            let unclipped = b.node("Reshape", &[&flat, &shape], "unclipped_crop");
            let (low, high) = (b.weight("crop.low", &[], &[0.0]), b.weight("crop.high", &[], &[1.0]));
            b.node("Clip", &[&unclipped, &low, &high], "crop");
        }
    }
    b.finish()
}

/// What a graph calls the measurement that it predicts.
fn predicted(architecture: &Architecture) -> &'static str {
    if architecture.kind() == Kind::ViewpointPredictive { "other_measurement" } else { "measurement" }
}

/// What a graph calls its conditioning.
fn conditioning(architecture: &Architecture) -> &'static str {
    if architecture.kind() == Kind::ViewpointPredictive { "change" } else { "conditioning" }
}

fn dense(b: &mut GraphBuilder, output: &str, input: &str, layer: &Dense) -> String {
    let weight =
        b.half_weight(&format!("{output}.weight"), &[layer.inputs(), layer.outputs()], &layer.weight);
    let bias = b.weight(&format!("{output}.bias"), &[layer.outputs()], &layer.bias);
    b.node("Gemm", &[input, &weight, &bias], output)
}

/// The latent turned by `-azimuth` into the camera's yaw frame; as it is, and no node, where nothing turns.
///
/// Pairs (`f`, `g`) become `c f + s g` and `c g - s f` by the cosine `c` and sine `s` of `m azimuth`: all pairs by their cosines, and
/// all pairs with their numbers swapped by their signed sines, which tract multiplies and adds as it stores them.
fn turned(b: &mut GraphBuilder, architecture: &Architecture) -> String {
    let output = "latent_in_camera";
    let (layout, told) = (architecture.latent, conditioning(architecture));
    let (pairs, numbers) = (layout.pairs(), architecture.conditioning());
    if pairs == 0 {
        return "latent".into();
    }
    let name = |part: &str| format!("{output}.{part}");
    let [invariant, straight] = b.split("latent", [("unturning", layout.invariant), (PAIRS, 2 * pairs)]);
    let (select_cos, select_sin) = selections(layout, numbers);
    b.weight("select_cos", &[numbers, 2 * pairs], &select_cos);
    b.weight("select_sin", &[numbers, 2 * pairs], &select_sin);
    b.weight("swap", &[2 * pairs, 2 * pairs], &swap(pairs));
    let cos = b.node("MatMul", &[told, "select_cos"], &name("cos"));
    let sin = b.node("MatMul", &[told, "select_sin"], &name("sin"));
    let swapped = b.node("MatMul", &[&straight, "swap"], &name("swapped"));
    let by_cos = b.node("Mul", &[&cos, &straight], &name("by_cos"));
    let by_sin = b.node("Mul", &[&swapped, &sin], &name("by_sin"));
    let turned = b.node("Add", &[&by_sin, &by_cos], &name("pairs"));
    b.concat(&[&invariant, &turned], output)
}

/// What [`turned`] calls the part of a latent that turns, before it is turned.
const PAIRS: &str = "pairs";

/// `[numbers, 2 pairs]` matrices that give the numbers of each pair the cosine and the sine of its harmonic, the second number the
/// negative sine.
fn selections(layout: LatentLayout, numbers: usize) -> (Vec<f32>, Vec<f32>) {
    let pairs = layout.pairs();
    let mut cos = vec![0.0; numbers * 2 * pairs];
    let mut sin = cos.clone();
    for column in 0..2 * pairs {
        let row = 2 * (layout.harmonic(column % pairs) - 1);
        cos[row * 2 * pairs + column] = 1.0;
        sin[(row + 1) * 2 * pairs + column] = if column < pairs { 1.0 } else { -1.0 };
    }
    (cos, sin)
}

/// A `[2 pairs, 2 pairs]` matrix that swaps the numbers of each pair.
fn swap(pairs: usize) -> Vec<f32> {
    let both = 2 * pairs;
    let mut swap = vec![0.0; both * both];
    for from in 0..both {
        swap[from * both + (from + pairs) % both] = 1.0;
    }
    swap
}

/// The decoder up to its last hidden layer.
struct Decoder {
    hidden: String,
    layers: Vec<Hidden>,
}

/// A hidden layer of the decoder: `x sigmoid(x)` of a linear layer's `x`.
struct Hidden {
    /// `sigmoid(x)`.
    gate: String,
    output: String,
}

fn decoder(b: &mut GraphBuilder, weights: &Weights) -> Decoder {
    let Weights { architecture, .. } = weights;
    let latent = &turned(b, architecture);
    let told = conditioning(architecture);
    let (numbers, seen) = (architecture.conditioning(), architecture.decoder_conditioning());
    let seen = if seen == numbers {
        told.to_owned()
    } else {
        let [_, seen] = b.split(told, [("unseen_azimuth", numbers - seen), ("seen", seen)]);
        seen
    };
    let source = architecture.decoder_sees_source.then_some("measurement");
    let class = architecture.latent_is_class.then(|| {
        let sharpness = b.weight("class.sharpness", &[], &[CLASS_SHARPNESS]);
        let sharpened = b.node("Mul", &[latent, &sharpness], "class.logits");
        b.node("Softmax", &[&sharpened], "class")
    });
    let latent = class.as_deref().unwrap_or(latent);
    let inputs: Vec<&str> = [latent, seen.as_str()].into_iter().chain(source).collect();
    let mut hidden = b.concat(&inputs, "decoder.input");
    let mut layers = Vec::new();
    for (index, layer) in weights.decoder.iter().enumerate() {
        let name = format!("decoder.{index}");
        let linear = dense(b, &name, &hidden, layer);
        let gate = b.node("Sigmoid", &[&linear], &format!("{name}.gate"));
        hidden = b.node("Mul", &[&linear, &gate], &format!("{name}.silu"));
        layers.push(Hidden { gate, output: hidden.clone() });
    }
    Decoder { hidden, layers }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canary::{Canary, TOLERANCE, deviation};
    use crate::onnx::graph::Graph;
    use crate::role::Convention;
    use crate::spec::{MOST_PAIRS, TrainingSpec};
    use crate::train::autoencoder::features::Frozen;
    use crate::train::autoencoder::network::Autoencoder;
    use crate::train::data::components::Components;
    use crate::train::data::views::Views;
    use crate::train::folder::canaries::Trainer;
    use crate::train::network::half::rounded_module;
    use crate::train::run::device::cpu;
    use crate::train::synthetic;
    use crate::train::trunk::network::TrunkWithHead;
    use burn::module::Module;
    use burn::tensor::Device;
    use nalgebra::DVector;
    use vantage_dataset::{Seed, Split};

    /// What an exported decoder sees beside a turned latent, or in its place.
    #[derive(Clone, Copy, PartialEq)]
    enum Seen {
        Nothing,
        Source,
        Class,
    }

    const LATENT: LatentLayout = LatentLayout { invariant: 3, pairs_per_harmonic: 2 };

    /// Untrained networks of unusual sizes: their graphs, and what burn computes of them.
    fn exported(
        convention: Convention,
        decoder_sees_azimuth: bool,
        seen: Seen,
        latent: LatentLayout,
    ) -> (Weights, Canary) {
        let latent_is_class = seen == Seen::Class;
        let architecture = Architecture {
            convention: Some(convention),
            trunk: vec![4, 6],
            features: 12,
            measurement: 5,
            encoder: vec![16],
            latent: if latent_is_class { LatentLayout { pairs_per_harmonic: 0, ..latent } } else { latent },
            decoder: vec![20, 9, 14],
            decoder_sees_azimuth,
            decoder_sees_source: seen == Seen::Source,
            latent_is_class,
            components: 7,
        };
        let (device, plain) = (cpu(), Device::flex());
        let set = synthetic::views(Split::Train, 4, 5, 1);
        let views = Views::new(&set, Split::Train, 2, &TrainingSpec::default(), Seed(1), false).unwrap();
        let trunk = TrunkWithHead::new(&architecture, &[5, 9], None, Seed(1), &device).trunk;
        let measurement = trunk.measurement_layer();
        let components = Components::fit(&set, architecture.components, Seed(1));
        let frozen = Frozen::fit(
            rounded_module(trunk.valid()),
            measurement,
            &views,
            &architecture,
            components,
            &plain,
        );
        let network = rounded_module(Autoencoder::new(&architecture, [4, 0], Seed(1), &device));
        let trainer = Trainer {
            network: &network,
            architecture: &architecture,
            unit_embedding: false,
            frozen: &frozen,
            features: &frozen.features(&views, &plain),
            views: &views,
            device: &device,
        };
        (network.weights(&architecture, &frozen, false), trainer.canary())
    }

    fn loaded(role: Role, weights: &Weights) -> Graph {
        Graph::from_bytes(&graph(role, weights), &signature(role, &weights.architecture)).unwrap()
    }

    #[test]
    fn every_graph_computes_what_burn_computes_derivatives_included() {
        let (viewpoint, change) = (Convention::AzimuthHarmonics, Convention::ObjectCentredChange);
        for (convention, decoder_sees_azimuth, seen) in [
            (viewpoint, false, Seen::Nothing),
            (viewpoint, true, Seen::Nothing),
            (viewpoint, true, Seen::Class),
            (change, false, Seen::Nothing),
            (change, false, Seen::Source),
            (change, true, Seen::Source),
        ] {
            let (weights, canary) = exported(convention, decoder_sees_azimuth, seen, LATENT);
            assert_eq!(canary.cases.len(), 2 * roles(&weights.architecture).len());
            for case in &canary.cases {
                let inputs: Vec<_> = case.inputs.iter().map(Vec::as_slice).collect();
                let outputs = loaded(case.role, &weights).run(&inputs).unwrap();
                for (got, expected) in outputs.iter().zip(&case.outputs) {
                    let told = seen == Seen::Source || case.role != Role::PredictorJacobian;
                    assert!(!told || expected.iter().any(|number| number.abs() > 1e-3), "{:?}", case.role);
                    let worst = deviation(got, expected);
                    assert!(worst < TOLERANCE, "{:?}: {worst}", case.role);
                }
            }
        }
    }

    #[test]
    fn the_most_pairs_that_a_training_may_have_make_graphs_that_load() {
        let most = LatentLayout { invariant: 384, pairs_per_harmonic: MOST_PAIRS };
        let (weights, _) = exported(Convention::ObjectCentredChange, false, Seen::Source, most);
        for role in roles(&weights.architecture) {
            loaded(role, &weights);
        }
    }

    #[test]
    fn turning_viewpoint_and_latent_together_changes_only_what_the_absolute_azimuth_tells() {
        let view = &synthetic::views(Split::Train, 1, 1, 3).views[0].viewpoint;
        let narrowed = |numbers: &[f64]| numbers.iter().map(|&number| number as f32).collect::<Vec<_>>();
        for decoder_sees_azimuth in [false, true] {
            let (weights, _) =
                exported(Convention::AzimuthHarmonics, decoder_sees_azimuth, Seen::Nothing, LATENT);
            let layout = weights.architecture.latent;
            let latent = DVector::from_fn(layout.dimension(), |i, _| libm::cos(i as f64));
            let decoder = loaded(Role::Decoder, &weights);
            let predicted = |angle: f64, turned: &DVector<f64>| {
                let x = narrowed(&view.turned(angle).conditioning());
                decoder.run(&[&narrowed(turned.as_slice()), &x]).unwrap().remove(0)
            };
            let here = predicted(0.0, &latent);
            for angle in [0.4, -2.5] {
                let together = deviation(&predicted(angle, &layout.turned(&latent, angle)), &here);
                let viewpoint_alone = deviation(&predicted(angle, &latent), &here);
                assert!(viewpoint_alone > 1e-2, "{viewpoint_alone}");
                assert_eq!(together < 1e-5, !decoder_sees_azimuth, "{together}");
            }
        }
    }
}
