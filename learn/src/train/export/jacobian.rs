//! The decoder's and the predictor's derivatives as a graph.

use super::{Hidden, PAIRS, conditioning, decoder, dense, predicted};
use crate::architecture::Architecture;
use crate::onnx::build::GraphBuilder;
use crate::role::Kind;
use crate::train::network::weights::{Dense, Weights};
use std::ops::Range;

/// Reverse mode: the rows of `d m / d .` are carried from the measurement back to the latent and conditioning.
///
/// A hidden layer `y = x s` with gate `s = sigmoid(x)` has the derivative `s + y (1 - s)`. What turning does to the
/// rows are two products with matrices of which [`turning`] tells: tract takes longer for sums and products of rows as short as a
/// pair's.
pub(super) fn jacobian(b: &mut GraphBuilder, weights: &Weights) {
    let Weights { architecture, decoder: layers, .. } = weights;
    let Architecture { latent: layout, measurement, .. } = *architecture;
    assert!(layout.pairs() > 0, "only latents that turn have this graph: see roles");
    let told = conditioning(architecture);
    let (numbers, seen) = (architecture.conditioning(), architecture.decoder_conditioning());
    let decoder = decoder(b, weights);
    dense(b, predicted(architecture), &decoder.hidden, &weights.decoded_measurement);
    let head = &weights.decoded_measurement;
    let mut rows = b.half_weight("back.head", &[head.outputs(), head.inputs()], &head.transposed());
    for (index, layer) in layers.iter().enumerate().rev() {
        let name = format!("back.{index}");
        let Hidden { gate, output } = &decoder.layers[index];
        let gated = b.node("Mul", &[output, gate], &format!("{name}.gated"));
        let rest = b.node("Sub", &[output, &gated], &format!("{name}.rest"));
        let slope = b.node("Add", &[gate, &rest], &format!("{name}.slope"));
        rows = b.node("Mul", &[&rows, &slope], &format!("{name}.sloped"));
        if index > 0 {
            let weight = layer.transposed();
            let weight =
                b.half_weight(&format!("{name}.weight"), &[layer.outputs(), layer.inputs()], &weight);
            rows = b.node("MatMul", &[&rows, &weight], &name);
        }
    }
    let mut back = |inputs: Range<usize>, output: &str| {
        let shape = [layers[0].outputs(), inputs.len()];
        let weight =
            b.half_weight(&format!("back.{output}.weight"), &shape, &layers[0].transposed_of(inputs));
        b.node("MatMul", &[&rows, &weight], output)
    };
    let seen_end = layout.dimension() + seen;
    let invariant = back(0..layout.invariant, "d_invariant");
    let turned = back(layout.invariant..seen_end, "d_turned");
    if architecture.decoder_sees_source {
        back(seen_end..layers[0].inputs(), "d_measurement");
    } else if architecture.kind() == Kind::ViewpointPredictive {
        let zeros = vec![0.0; measurement * measurement];
        let unseen = b.weight("unseen_measurement", &[measurement, measurement], &zeros);
        b.node("Identity", &[&unseen], "d_measurement");
    }
    let [to_pairs, to_told] = turning(architecture);
    let shape = [layout.dimension() - layout.invariant + seen, 2 * layout.pairs()];
    let to_pairs = made(b, "turning.pairs", told, &to_pairs, shape);
    let to_told = made(b, &format!("turning.{told}"), PAIRS, &to_told, [shape[0], numbers]);
    let d_pairs = b.node("MatMul", &[&turned, &to_pairs], "d_pairs");
    b.node("MatMul", &[&turned, &to_told], &format!("d_{told}"));
    b.concat(&[&invariant, &d_pairs], "d_latent");
}

/// A matrix of numbers that a layer gives.
fn made(b: &mut GraphBuilder, name: &str, input: &str, layer: &Dense, shape: [usize; 2]) -> String {
    let flat = dense(b, &format!("{name}.flat"), input, layer);
    let shape = b.sizes(&format!("{name}.shape"), &shape);
    b.node("Reshape", &[&flat, &shape], name)
}

/// The derivatives of turned pairs (`u`, `v`) and of what the decoder sees of the conditioning, `2 pairs + seen` rows: to the
/// pairs (`f`, `g`) as they were, from the conditioning; and to the conditioning, from the pairs.
///
/// With `u = c f + s g` and `v = c g - s f`, cosine `c` and sine `s` of `m azimuth`, the derivatives to one are linear in the
/// other.
fn turning(architecture: &Architecture) -> [Dense; 2] {
    let Architecture { latent: layout, .. } = *architecture;
    let (pairs, numbers) = (layout.pairs(), architecture.conditioning());
    let seen = architecture.decoder_conditioning();
    let rows = 2 * pairs + seen;
    let zeros = |inputs: usize, columns: usize| Dense {
        weight: vec![0.0; inputs * rows * columns],
        bias: vec![0.0; rows * columns],
    };
    let (mut to_pairs, mut to_told) = (zeros(numbers, 2 * pairs), zeros(2 * pairs, numbers));
    for pair in 0..pairs {
        let (f, g) = (pair, pairs + pair);
        let (u, v) = (f, g);
        let c = 2 * (layout.harmonic(pair) - 1);
        let s = c + 1;
        for (turned, told, of, sign) in [(u, c, f, 1.0), (u, s, g, 1.0), (v, c, g, 1.0), (v, s, f, -1.0)] {
            to_pairs.weight[(told * rows + turned) * 2 * pairs + of] = sign;
            to_told.weight[(of * rows + turned) * numbers + told] = sign;
        }
    }
    for number in 0..seen {
        to_told.bias[(2 * pairs + number) * numbers + numbers - seen + number] = 1.0;
    }
    [to_pairs, to_told]
}
