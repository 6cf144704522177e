//! Metric learning by the InfoNCE loss of van den Oord et al. 2018: alone it is a rival of the paper's models, and a trunk may learn it beside
//! viewpoints.

use super::autoencoder::Bound;
use super::autoencoder_network::{Autoencoder, encoder_input};
use super::exponential::log_softmax;
use super::rows::table;
use super::run::{Step, scalar};
use super::turn::Turn;
use burn::optim::GradientsParams;
use burn::tensor::{Device, Tensor};

/// What similarities are divided by.
const TEMPERATURE: f64 = 0.1;
/// Added to the similarity of a row to itself, so that it is never taken for its own partner.
const FORBIDDEN: f32 = -1e4;

/// Cross-entropy of finding, for each of `2 n` rows, its partner `n` rows away among all others, by cosine similarity.
pub(crate) fn loss(embedded: Tensor<2>, device: &Device) -> Tensor<1> {
    let rows = embedded.dims()[0];
    let unit = normalized(embedded);
    let square = |entry: fn(usize, usize, usize) -> f32| {
        table((0..rows * rows).map(|i| entry(i / rows, i % rows, rows)).collect(), rows, device)
    };
    let itself = square(|row, column, _| if row == column { FORBIDDEN } else { 0.0 });
    let partner = square(|row, column, rows| if (row + rows / 2) % rows == column { 1.0 } else { 0.0 });
    let similarity = unit.clone().matmul(unit.transpose()) / TEMPERATURE + itself;
    (log_softmax(similarity) * partner).sum_dim(1).mean().neg()
}

/// Rows of unit length.
pub(crate) fn normalized(rows: Tensor<2>) -> Tensor<2> {
    let length = (rows.clone().square().sum_dim(1) + 1e-12).sqrt();
    rows / length
}

/// The loss of the encoder's means on the random batch of a step: `batch * views / 2` instances, two crops of each.
pub(crate) fn step(network: &Autoencoder, bound: &Bound, index: usize) -> Step<4> {
    let Bound { views, features, spec, architecture, seed, device } = *bound;
    let mut stream = seed.stream("contrastive batch", index as u64);
    let half = (spec.batch * spec.views / 2).max(2) as usize;
    let rows = views.pairs(half, &mut stream);
    let nothing = table(Vec::new(), rows.len(), device);
    let inputs = encoder_input(architecture, features.crop(&rows, device), &nothing);
    let turn = Turn::new(architecture.latent, &nothing);
    let factor = network.encode(architecture.latent, inputs, &turn);
    let total = loss(factor.mean, device);
    let value = scalar(&total);
    let gradients = GradientsParams::from_grads(total.backward(), network);
    Step { loss: value, terms: [0.0, 0.0, 0.0, value], gradients }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partners_that_agree_cost_little_and_ones_that_do_not_cost_much() {
        let device = Device::flex();
        let rows = |numbers: &[f32]| table(numbers.to_vec(), 4, &device);
        let right = scalar(&loss(rows(&[1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 3.0]), &device));
        let wrong = scalar(&loss(rows(&[1.0, 0.0, 0.0, 1.0, 0.0, 2.0, 3.0, 0.0]), &device));
        assert!(right < 1e-3 && wrong > 9.0, "{right} {wrong}");
        let blind = scalar(&loss(rows(&[1.0; 8]), &device));
        assert!((blind - 3f64.ln()).abs() < 1e-4, "{blind}");
    }
}
