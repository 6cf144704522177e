//! A rival of the paper's models: the encoder alone, by the InfoNCE loss of pairs of crops, without viewpoints.

use super::Bound;
use super::network::{Autoencoder, encoder_input};
use crate::train::network::rows::table;
use crate::train::network::turn::Turn;
use crate::train::run::{Step, scalar};
use crate::train::trunk::info_nce::loss_of_pairs;
use burn::optim::GradientsParams;

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
    let total = loss_of_pairs(factor.mean, device);
    let value = scalar(&total);
    let gradients = GradientsParams::from_grads(total.backward(), network);
    Step { loss: value, terms: [0.0, 0.0, 0.0, value], gradients }
}
