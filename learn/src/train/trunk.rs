//! Stage 1: the trunk learns features that tell the viewpoint (IV-C: "sensitive to viewpoint changes").

use super::network::{AZIMUTH_BINS, TrunkWithHead, upright};
use super::run::{Step, scalar};
use super::views::{Views, gather, numbers};
use crate::spec::TrainingSpec;
use burn::optim::GradientsParams;
use burn::tensor::activation::log_softmax;
use burn::tensor::{Device, Tensor, TensorData};
use std::f64::consts::PI;
use vantage_dataset::Seed;
use vantage_dataset::viewpoint::CONDITIONING;

/// Concentration of the azimuth's soft label: about 13 degrees wide.
const CONCENTRATION: f64 = 20.0;
/// Weight of the squared error of the upright conditioning.
const UPRIGHT_WEIGHT: f64 = 2.0;

/// Cross-entropy of the azimuth over bins, which can be told apart or not (symmetric objects cannot), and the
/// squared error of the rest of `x_rel`.
pub(crate) fn step(
    network: &TrunkWithHead,
    views: &Views,
    spec: &TrainingSpec,
    seed: Seed,
    index: usize,
    device: &Device,
) -> Step<2> {
    let mut stream = seed.stream("trunk batch", index as u64);
    let batch: Vec<usize> = (0..spec.trunk_batch).map(|_| stream.below(views.len())).collect();
    let convolutions = network.trunk.convolutions();
    let pass = convolutions.pass(&views.crops(batch.iter().copied()));
    let outputs = pass.outputs();
    let shape = [batch.len(), outputs.len() / batch.len()];
    let convolved = Tensor::<2>::from_data(TensorData::new(outputs, shape), device).require_grad();
    let (logits, predicted) = network.forward(convolved.clone());
    let labels = soft_labels(views, &batch, device);
    let azimuth = (log_softmax(logits, 1) * labels).sum_dim(1).mean().neg();
    let conditioning = gather(&views.conditioning, CONDITIONING, &batch, device);
    let upright = (predicted - upright(conditioning)).square().mean();
    let total = azimuth.clone() + upright.clone() * UPRIGHT_WEIGHT;
    let tape = total.backward();
    let d_convolved = numbers(convolved.grad(&tape).expect("the loss depends on the convolutions"));
    let mut gradients = GradientsParams::from_grads(tape, network);
    network.trunk.register(
        convolutions.backward(&pass, &d_convolved),
        &mut gradients,
        &device.clone().inner(),
    );
    Step { loss: scalar(&total), terms: [scalar(&azimuth), scalar(&upright)], gradients }
}

/// A von Mises bump around the true azimuth, over the bins.
fn soft_labels(views: &Views, batch: &[usize], device: &Device) -> Tensor<2> {
    let mut labels = Vec::with_capacity(batch.len() * AZIMUTH_BINS);
    for &view in batch {
        let azimuth = views.set.views[view].viewpoint.azimuth();
        let center = |bin: usize| (bin as f64 + 0.5) * 2.0 * PI / AZIMUTH_BINS as f64;
        let bump = |bin| libm::exp(CONCENTRATION * (libm::cos(azimuth - center(bin)) - 1.0));
        let total: f64 = (0..AZIMUTH_BINS).map(bump).sum();
        labels.extend((0..AZIMUTH_BINS).map(|bin| (bump(bin) / total) as f32));
    }
    Tensor::from_data(TensorData::new(labels, [batch.len(), AZIMUTH_BINS]), device)
}
