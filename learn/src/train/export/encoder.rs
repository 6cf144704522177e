//! Trunk and encoder as graphs.

use super::{Turn, dense, turned};
use crate::architecture::{LOG_VARIANCE, PIXEL_CENTER, UPRIGHT};
use crate::onnx::build::{GraphBuilder, integers};
use crate::role::Kind;
use crate::train::weights::Weights;
use vantage_dataset::crop::CROP_BYTES;
use vantage_dataset::viewpoint::HARMONICS;

/// `t(z)` of `crop`.
pub(super) fn trunk(b: &mut GraphBuilder, weights: &Weights) -> String {
    let center = b.weight("pixel_center", &[], &[PIXEL_CENTER]);
    let mut x = b.node("Sub", &["crop", &center], "centered_crop");
    let mut inputs = 3;
    for (index, conv) in weights.trunk.iter().enumerate() {
        let (name, outputs) = (format!("trunk.{index}"), conv.bias.len());
        let weight = b.half_weight(&format!("{name}.weight"), &[outputs, inputs, 4, 4], &conv.weight);
        let bias = b.weight(&format!("{name}.bias"), &[outputs], &conv.bias);
        let attributes = vec![
            integers("kernel_shape", &[4, 4]),
            integers("strides", &[2, 2]),
            integers("pads", &[1, 1, 1, 1]),
        ];
        b.node_with("Conv", &[&x, &weight, &bias], &[&name], attributes);
        x = b.node("Relu", &[&name], &format!("{name}.relu"));
        inputs = outputs;
    }
    let flat = b.node("Flatten", &[&x], "trunk.flat");
    let features = dense(b, "features", &flat, &weights.features);
    b.node("Relu", &[&features], "features.relu")
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
    let last = weights.encoder.len() - 1;
    for (index, layer) in weights.encoder.iter().enumerate() {
        x = dense(b, &format!("encoder.{index}"), &x, layer);
        if index < last {
            x = b.node("Relu", &[&x], &format!("encoder.{index}.relu"));
        }
    }
    let free = layout.invariant + layout.pairs();
    let [mean, raw] = b.split(&x, [("mean_in_camera", layout.dimension()), ("raw_log_variance", free)]);
    if architecture.kind() == Kind::Embedding {
        return embedding(b, weights, &mean, &raw);
    }
    let turned = match architecture.kind() {
        Kind::ViewpointDependent => turned(b, architecture, "mean", &mean, Turn::IntoObject),
        _ => None,
    };
    if turned.is_none() {
        b.node("Identity", &[&mean], "mean");
    }
    let clipped = clipped(b, &raw, if layout.pairs() == 0 { "log_variance" } else { "log_variance.clipped" });
    if layout.pairs() > 0 {
        let parts = [("log_variance.invariant", layout.invariant), ("log_variance.pairs", layout.pairs())];
        let [invariant, pairs] = b.split(&clipped, parts);
        b.concat(&[&invariant, &pairs, &pairs], "log_variance");
    }
}

fn clipped(b: &mut GraphBuilder, raw: &str, output: &str) -> String {
    let low = b.weight("log_variance.low", &[], &[LOG_VARIANCE.0]);
    let high = b.weight("log_variance.high", &[], &[LOG_VARIANCE.1]);
    b.node("Clip", &[raw, &low, &high], output)
}

/// What single crops are compared by: of a contrastive model, the mean's direction; of an autoencoder the mean after one
/// view and the prior, `mean / (1 + variance)`.
fn embedding(b: &mut GraphBuilder, weights: &Weights, mean: &str, raw: &str) {
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
        let log_variance = clipped(b, raw, "log_variance.clipped");
        let log_precision = b.node("Neg", &[&log_variance], "log_precision");
        let share = b.node("Sigmoid", &[&log_precision], "share");
        b.node("Mul", &[mean, &share], "mean");
    }
}
