//! A rival of the paper's models: a discrete class in place of the latent, `p(z | c, x_rel)` of Eq. 8, and a classifier
//! `P(c | z, x_rel)`; both need the class of every training instance.

use super::network::{Autoencoder, decoder_input, encoder_input};
use super::{Bound, negative_log_likelihood};
use crate::train::network::CLASS_SHARPNESS;
use crate::train::network::exponential::log_softmax;
use crate::train::network::rows::table;
use crate::train::network::turn::Turn;
use crate::train::run::{Step, scalar};
use burn::optim::GradientsParams;
use burn::tensor::{Tensor, TensorData};

/// Logit of the true class above the others, where the decoder is told of it.
const CERTAIN: f32 = 20.0;

/// Cross-entropy of the classifier and negative log-likelihood of measurement and image given the class, on random views.
pub(crate) fn step(network: &Autoencoder, bound: &Bound, index: usize) -> Step<4> {
    let Bound { views, features, spec, architecture, seed, device } = *bound;
    let mut stream = seed.stream("class batch", index as u64);
    let rows = (spec.batch * spec.views) as usize;
    let (mut batch, mut classes) = (Vec::new(), vec![0.0; rows * architecture.latent.dimension()]);
    for row in 0..rows {
        let group = &views.groups[stream.below(views.groups.len())];
        batch.push(group.views[stream.below(group.views.len())]);
        let class = views.tags[group.instance].expect("a training by class tags all instances");
        classes[row * architecture.latent.dimension() + class] = 1.0;
    }
    let conditioning =
        batch.iter().flat_map(|&view| views.conditioning(architecture.convention, view, view, false));
    let conditioning = table(conditioning.collect(), rows, device);
    let turn = Turn::new(architecture.latent, &conditioning);
    let inputs = encoder_input(architecture, features.crop(&batch, device), &conditioning);
    let classes = table(classes, rows, device);
    let logits = network.encode(architecture.latent, inputs, &turn).mean;
    let class = (log_softmax(logits) * classes.clone()).sum_dim(1).mean().neg();

    let seen = decoder_input(architecture, &conditioning, None);
    let decoded = network.decode(architecture, classes * (CERTAIN / CLASS_SHARPNESS), seen, &turn);
    let residual = features.measurement(&batch, device) - decoded.measurement;
    let measurement =
        negative_log_likelihood(residual, network.log_sigma_measurement.val()).sum_dim(1).mean();
    let residual = features.image(&batch, device) - decoded.image;
    let weights = Tensor::<1>::from_data(TensorData::from(&features.image_weights[..]), device);
    let image = negative_log_likelihood(residual, network.log_sigma_image.val()) * weights.unsqueeze();
    let image = image.sum_dim(1).mean();

    let terms = [scalar(&measurement), scalar(&image), 0.0, scalar(&class)];
    let total = measurement + image * spec.image_weight + class;
    let loss = scalar(&total);
    Step { loss, terms, gradients: GradientsParams::from_grads(total.backward(), network) }
}
