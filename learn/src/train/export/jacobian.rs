//! The decoder's and the predictor's derivatives as a graph.

use super::{Hidden, Turned, conditioning, decoder, dense, predicted, selections};
use crate::architecture::Architecture;
use crate::onnx::build::GraphBuilder;
use crate::role::Kind;
use crate::train::weights::{Dense, Weights};
use vantage_dataset::viewpoint::HARMONICS;

/// Reverse mode: the rows of `d m / d .` are carried from the measurement back to the latent and conditioning.
///
/// A hidden layer `y = x s` with gate `s = sigmoid(x)` has the derivative `s + y (1 - s)`. With `u = c f + s g`, `v = c g - s f` the turned pairs (`f`, `g`;
/// cosine `c`, sine `s` of `m azimuth`), `df = c du - s dv`, `dg = s du + c dv`, `dc = f du + g dv` and
/// `ds = g du - f dv`.
pub(super) fn jacobian(b: &mut GraphBuilder, weights: &Weights) {
    let Architecture { latent: layout, .. } = weights.architecture;
    let (told, numbers) = (conditioning(&weights.architecture), weights.architecture.conditioning());
    let decoder = decoder(b, weights);
    dense(b, predicted(&weights.architecture), &decoder.hidden, &weights.decoded_measurement);
    let head = &weights.decoded_measurement;
    let mut rows = b.half_weight("back.head", &[head.outputs(), head.inputs()], &head.transposed());
    for (index, layer) in weights.decoder.iter().enumerate().rev() {
        let name = format!("back.{index}");
        let Hidden { gate, output } = &decoder.layers[index];
        let gated = b.node("Mul", &[output, gate], &format!("{name}.gated"));
        let rest = b.node("Sub", &[output, &gated], &format!("{name}.rest"));
        let slope = b.node("Add", &[gate, &rest], &format!("{name}.slope"));
        let sloped = b.node("Mul", &[&rows, &slope], &format!("{name}.sloped"));
        let shape = [layer.outputs(), layer.inputs()];
        let weight = b.half_weight(&format!("{name}.weight"), &shape, &layer.transposed());
        rows = b.node("MatMul", &[&sloped, &weight], &name);
    }
    let pairs = layout.pairs();
    let beside = weights.architecture.decoder_inputs() - layout.dimension();
    let parts = [("d_invariant", layout.invariant), ("du", pairs), ("dv", pairs), ("d_beside", beside)];
    let [d_invariant, du, dv, d_beside] = b.split(&rows, parts);
    let d_seen = seen_alone(b, weights, d_beside);
    let turned = decoder.turned.as_ref().expect("only latents that turn have this graph: see roles");
    let Turned { first, second, cos, sin, .. } = turned;
    let mut combined = |operator: &str, output: &str, (a, x): (&str, &str), (c, y): (&str, &str)| {
        let left = b.node("Mul", &[x, a], &format!("{output}.left"));
        let right = b.node("Mul", &[y, c], &format!("{output}.right"));
        b.node(operator, &[&left, &right], output)
    };
    let df = combined("Sub", "d_first", (cos, &du), (sin, &dv));
    let dg = combined("Add", "d_second", (sin, &du), (cos, &dv));
    let dc = combined("Add", "d_cos", (first, &du), (second, &dv));
    let ds = combined("Sub", "d_sin", (second, &du), (first, &dv));
    b.concat(&[&d_invariant, &df, &dg], "d_latent");
    let transposed = |selection: Vec<f32>| Dense { weight: selection, bias: vec![0.0; pairs] }.transposed();
    let (select_cos, select_sin) = selections(layout, numbers);
    let spread_cos = b.weight("spread_cos", &[pairs, numbers], &transposed(select_cos));
    let spread_sin = b.weight("spread_sin", &[pairs, numbers], &transposed(select_sin));
    let by_cos = b.node("MatMul", &[&dc, &spread_cos], &format!("d_{told}.cos"));
    let by_sin = b.node("MatMul", &[&ds, &spread_sin], &format!("d_{told}.sin"));
    let by_turning = b.node("Add", &[&by_cos, &by_sin], &format!("d_{told}.turning"));
    let seen = spread_seen(b, weights, &d_seen, head.outputs());
    b.node("Add", &[&by_turning, &seen], &format!("d_{told}"));
}

/// The derivative to what the decoder sees of the conditioning; that to the source's measurement beside it becomes the
/// predictor's `d_measurement`.
fn seen_alone(b: &mut GraphBuilder, weights: &Weights, d_beside: String) -> String {
    let Architecture { measurement, decoder_sees_source, .. } = weights.architecture;
    if decoder_sees_source {
        let parts = [("d_seen", weights.architecture.decoder_conditioning()), ("d_measurement", measurement)];
        let [d_seen, _] = b.split(&d_beside, parts);
        return d_seen;
    }
    if weights.architecture.kind() == Kind::ViewpointPredictive {
        let zeros = vec![0.0; measurement * measurement];
        let unseen = b.weight("unseen_measurement", &[measurement, measurement], &zeros);
        b.node("Identity", &[&unseen], "d_measurement");
    }
    d_beside
}

/// The derivative to what the decoder sees of the conditioning, with zeros for what it does not.
fn spread_seen(b: &mut GraphBuilder, weights: &Weights, d_seen: &str, rows: usize) -> String {
    if weights.architecture.decoder_sees_azimuth {
        return d_seen.to_owned();
    }
    let zeros = b.weight("unseen", &[rows, 2 * HARMONICS], &vec![0.0; rows * 2 * HARMONICS]);
    b.concat(&[&zeros, d_seen], "d_seen.spread")
}
