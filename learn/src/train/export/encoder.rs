//! Trunk and encoder as graphs.

use super::{dense, selections};
use crate::architecture::UPRIGHT;
use crate::onnx::build::{GraphBuilder, integers, real};
use crate::role::Kind;
use crate::train::network::weights::{Conv, Dense, Weights};
use crate::train::network::{LOG_VARIANCE, PIXEL_CENTER};
use vantage_dataset::crop::CROP_BYTES;
use vantage_dataset::viewpoint::HARMONICS;

/// `t(z)` of `crop`.
///
/// The first convolution takes centred pixels: what they are centred by goes into its bias, and around the crop. After
/// convolutions, ReLUs are leaky ones that leak nothing: those alone are applied by tract as it stores a convolution's sums.
pub(super) fn trunk(b: &mut GraphBuilder, weights: &Weights) -> String {
    let around = b.sizes("around", &[0, 0, 1, 1, 0, 0, 1, 1]);
    let center = b.weight("pixel_center", &[], &[PIXEL_CENTER]);
    let mut x = b.node("Pad", &["crop", &around, &center], "padded_crop");
    let mut inputs = 3;
    for (index, conv) in weights.trunk.iter().enumerate() {
        let (name, outputs) = (format!("trunk.{index}"), conv.bias.len());
        let weight = b.half_weight(&format!("{name}.weight"), &[outputs, inputs, 4, 4], &conv.weight);
        let (bias, padding) = if index == 0 { (centring(conv), 0) } else { (conv.bias.clone(), 1) };
        let bias = b.weight(&format!("{name}.bias"), &[outputs], &bias);
        let attributes = vec![
            integers("kernel_shape", &[4, 4]),
            integers("strides", &[2, 2]),
            integers("pads", &[padding; 4]),
        ];
        b.node_with("Conv", &[&x, &weight, &bias], &[&name], attributes);
        x = format!("{name}.relu");
        b.node_with("LeakyRelu", &[&name], &[&x], vec![real("alpha", 0.0)]);
        inputs = outputs;
    }
    let flat = b.node("Flatten", &[&x], "trunk.flat");
    let features = dense(b, "features", &flat, &weights.features);
    b.node("Relu", &[&features], "features.relu")
}

/// The bias that makes a convolution of plain pixels equal to that of centred ones.
fn centring(conv: &Conv) -> Vec<f32> {
    let taps = conv.weight.len() / conv.bias.len();
    let sums = conv.weight.chunks(taps).map(|taps| taps.iter().map(|&tap| f64::from(tap)).sum::<f64>());
    conv.bias
        .iter()
        .zip(sums)
        .map(|(&b, sum)| (f64::from(b) - f64::from(PIXEL_CENTER) * sum) as f32)
        .collect()
}

pub(super) fn encoder(b: &mut GraphBuilder, weights: &Weights) {
    let Weights { architecture, .. } = weights;
    let layout = architecture.latent;
    let features = trunk(b, weights);
    let mean = b.weight("features.mean", &[1, weights.feature_mean.len()], &weights.feature_mean);
    let scale = b.weight("features.scale", &[1, weights.feature_scale.len()], &weights.feature_scale);
    let centered = b.node("Sub", &[&features, &mean], "features.centered");
    let standard = b.node("Mul", &[&centered, &scale], "features.standard");
    let shape = b.sizes("flat.shape", &[1, CROP_BYTES]);
    let flat = b.node("Reshape", &["crop", &shape], "flat");
    let coefficients = dense(b, "coefficients", &flat, &weights.projection);
    let mut inputs = vec![standard, coefficients];
    if architecture.encoder_conditioning() > 0 {
        let parts = [("azimuth_harmonics", 2 * HARMONICS), ("upright", UPRIGHT)];
        let [_, upright] = b.split("conditioning", parts);
        inputs.push(upright);
    }
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    let mut x = b.concat(&inputs, "encoder.input");
    let (last, hidden) = weights.encoder.split_last().expect("a linear layer follows the hidden ones");
    for (index, layer) in hidden.iter().enumerate() {
        let linear = dense(b, &format!("encoder.{index}"), &x, layer);
        x = b.node("Relu", &[&linear], &format!("encoder.{index}.relu"));
    }
    let (dimension, free) = (layout.dimension(), layout.invariant + layout.pairs());
    let mean = last.columns(0..dimension);
    let raw = last.columns(dimension..dimension + free);
    match architecture.kind() {
        Kind::Embedding => return embedding(b, weights, &x, [&mean, &raw]),
        Kind::ViewpointDependent if layout.pairs() > 0 => turned_mean(b, weights, &x, &mean),
        _ => {
            dense(b, "mean", &x, &mean);
        }
    }
    let both = raw.columns((0..free).chain(layout.invariant..free));
    let raw = dense(b, "raw_log_variance", &x, &both);
    clipped(b, &raw, "log_variance");
}

/// The mean of `x`, turned by `+azimuth` from the camera's yaw frame into the object's: pairs (`f`, `g`) become `c f - s g` and
/// `c g + s f` by the cosine `c` and sine `s` of `m azimuth`. Two linear layers give both terms, so that tract multiplies them as it
/// stores them.
fn turned_mean(b: &mut GraphBuilder, weights: &Weights, x: &str, mean: &Dense) {
    let Weights { architecture, .. } = weights;
    let (layout, numbers) = (architecture.latent, architecture.conditioning());
    let (invariant, pairs, dimension) = (layout.invariant, layout.pairs(), layout.dimension());
    let (select_cos, select_sin) = selections(layout, numbers);
    let mut cos = Dense { weight: vec![0.0; numbers * dimension], bias: vec![0.0; dimension] };
    cos.bias[..invariant].fill(1.0);
    for (row, selected) in cos.weight.chunks_mut(dimension).zip(select_cos.chunks(2 * pairs)) {
        row[invariant..].copy_from_slice(selected);
    }
    let sin: Vec<f32> = select_sin.iter().map(|&number| -number).collect();
    let by_cos = dense(b, "mean.cos", "conditioning", &cos);
    let straight = dense(b, "mean.straight", x, mean);
    let straight = b.node("Mul", &[&straight, &by_cos], "mean.by_cos");
    let signed_sin = b.weight("mean.select_sin", &[numbers, 2 * pairs], &sin);
    let by_sin = b.node("MatMul", &["conditioning", &signed_sin], "mean.sin");
    let swapped = mean.columns((invariant + pairs..dimension).chain(invariant..invariant + pairs));
    let crossed = dense(b, "mean.crossed", x, &swapped);
    let crossed = b.node("Mul", &[&crossed, &by_sin], "mean.by_sin");
    let nothing = b.weight("mean.unturned", &[1, invariant], &vec![0.0; invariant]);
    let crossed = b.concat(&[&nothing, &crossed], "mean.turned");
    b.node("Add", &[&straight, &crossed], "mean");
}

fn clipped(b: &mut GraphBuilder, raw: &str, output: &str) -> String {
    let low = b.weight("log_variance.low", &[], &[LOG_VARIANCE.0]);
    let high = b.weight("log_variance.high", &[], &[LOG_VARIANCE.1]);
    b.node("Clip", &[raw, &low, &high], output)
}

/// What single crops are compared by: of a contrastive model, the mean's direction; of an autoencoder the mean after one
/// view and the prior, `mean / (1 + variance)`.
fn embedding(b: &mut GraphBuilder, weights: &Weights, x: &str, [mean, raw]: [&Dense; 2]) {
    let mean = &dense(b, "mean_in_camera", x, mean);
    if weights.unit_embedding {
        let dimension = weights.architecture.latent.dimension();
        let ones = b.weight("ones", &[dimension, 1], &vec![1.0; dimension]);
        let least = b.weight("least", &[], &[1e-12]);
        let squares = b.node("Mul", &[mean, mean], "squares");
        let sum = b.node("MatMul", &[&squares, &ones], "sum");
        let positive = b.node("Add", &[&sum, &least], "positive");
        let length = b.node("Sqrt", &[&positive], "length");
        b.node("Div", &[mean, &length], "mean");
    } else {
        let raw = dense(b, "raw_log_variance", x, raw);
        let log_variance = clipped(b, &raw, "log_variance.clipped");
        let log_precision = b.node("Neg", &[&log_variance], "log_precision");
        let share = b.node("Sigmoid", &[&log_precision], "share");
        b.node("Mul", &[mean, &share], "mean");
    }
}
