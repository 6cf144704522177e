//! Stage 2: encoder and decoder by the evidence lower bound of Eq. 12, for several views at once.
//!
//! For views `1..=V` of one instance, of which the first `K` are encoded,
//! `log p(z_1..z_V, beta | x_1..x_V) >= sum_v E_q log p(z_v | e, x_v) - KL(q || N(0, I)) + log p(e | beta)` with
//! `q(e | z_1..z_K, x_1..x_K)` the product of the encoder's factors and the prior. With `V = K = 1` it is Eq. 12.

use super::features::Features;
use super::network::{Autoencoder, Turn, for_each_number, seen, upright};
use super::run::{Step, scalar};
use super::views::Views;
use crate::architecture::Architecture;
use crate::spec::TrainingSpec;
use burn::optim::GradientsParams;
use burn::tensor::{Device, Int, Tensor, TensorData};
use vantage_dataset::{Seed, Stream};

/// Share of the steps over which the divergence and the instance term come in: with their full weight from the start,
/// a decoder that does not know the latent yet teaches the encoder to say nothing.
const WARM_UP: f64 = 0.3;

/// Views of some instances, as many of each: rows are instance by instance.
struct Batch {
    /// Index of each row's instance among those with two views or more.
    instances: Vec<i64>,
    /// View of each row.
    views: Vec<usize>,
    /// 1 for rows that are encoded, 0 for those that are only predicted.
    encoded: Vec<f32>,
    /// Standard normal draws, `[instances, latent]`.
    noise: Vec<f32>,
}

impl Batch {
    fn draw(views: &Views, spec: &TrainingSpec, latent: usize, stream: &mut Stream) -> Self {
        let (instances, rows) = (spec.batch as usize, spec.views as usize);
        let mut batch =
            Self { instances: Vec::new(), views: Vec::new(), encoded: Vec::new(), noise: Vec::new() };
        for _ in 0..instances {
            let instance = stream.below(views.by_instance.len());
            let mut order = views.by_instance[instance].clone();
            stream.shuffle(&mut order);
            let most = order.len().min(rows).min(spec.context as usize);
            let encoded = 1 + stream.below(most);
            for row in 0..rows {
                batch.instances.push(instance as i64);
                batch.views.push(order[row % order.len()]);
                batch.encoded.push(if row < encoded { 1.0 } else { 0.0 });
            }
        }
        batch.noise.extend((0..instances * latent).map(|_| stream.normal() as f32));
        batch
    }
}

/// What the bound is taken over.
pub(crate) struct Bound<'a> {
    pub(crate) views: &'a Views<'a>,
    pub(crate) features: &'a Features,
    pub(crate) spec: &'a TrainingSpec,
    pub(crate) architecture: &'a Architecture,
    pub(crate) seed: Seed,
    pub(crate) device: &'a Device,
}

/// The negative bound of the random batch of a step, a view.
pub(crate) fn step(network: &Autoencoder, bound: &Bound, index: usize) -> Step<4> {
    let Bound { views, features, spec, architecture, seed, device } = *bound;
    let layout = architecture.latent;
    let dimension = layout.dimension();
    let mut stream = seed.stream("autoencoder batch", index as u64);
    let batch = Batch::draw(views, spec, dimension, &mut stream);
    let (count, per_instance) = (spec.batch as usize, spec.views as usize);
    let rows = count * per_instance;

    let conditioning = features.conditioning(&batch.views, device);
    let turn = Turn::new(layout, &conditioning);
    let factor =
        network.encode(layout, features.crop(&batch.views, device), upright(conditioning.clone()), &turn);
    let precision = factor.log_variance.neg().exp();

    let encoded = Tensor::<2>::from_data(TensorData::new(batch.encoded, [rows, 1]), device);
    let informed = for_each_number(layout, precision.clone() * encoded);
    let over_views = |tensor: Tensor<2>| tensor.reshape([count, per_instance, dimension]).sum_dim(1);
    let weighted = over_views(informed.clone() * factor.mean.clone());
    let variance = (over_views(informed) + 1.0).recip();
    let mean = weighted * variance.clone();
    let noise = Tensor::<3>::from_data(TensorData::new(batch.noise, [count, 1, dimension]), device);
    let latent = mean.clone() + variance.clone().sqrt() * noise;

    let latents = latent.expand([count, per_instance, dimension]).reshape([rows, dimension]);
    let decoded = network.decode(layout, latents, seen(architecture, conditioning), &turn);
    let measurement = negative_log_likelihood(
        features.measurement(&batch.views, device) - decoded.measurement,
        network.log_sigma_measurement.val(),
    );
    let image_terms = negative_log_likelihood(
        features.image(&batch.views, device) - decoded.image,
        network.log_sigma_image.val(),
    );
    let weights = Tensor::<1>::from_data(TensorData::from(&features.image_weights[..]), device);
    let image = (image_terms * weights.unsqueeze()).sum_dim(1).mean();
    let measurement = measurement.sum_dim(1).mean();

    let divergence = (mean.square() + variance.clone() - variance.log() - 1.0).sum() * (0.5 / rows as f64);
    let instances = Tensor::<1, Int>::from_data(TensorData::new(batch.instances, [rows]), device);
    let means = network.instance_means.val().select(0, instances);
    let instance = instance_term(
        factor.mean.narrow(1, 0, layout.invariant),
        precision.narrow(1, 0, layout.invariant),
        means,
        spec.instance_sigma,
    );
    let warm = (((index + 1) as f64) / (WARM_UP * f64::from(spec.steps))).min(1.0);
    let total = measurement.clone()
        + image.clone() * spec.image_weight
        + divergence.clone() * warm
        + instance.clone() * warm;
    let gradients = GradientsParams::from_grads(total.backward(), network);
    let terms = [measurement, image, divergence, instance].map(|term| scalar(&term));
    Step { loss: scalar(&total), terms, gradients }
}

/// `-log N(residual; 0, sigma^2)` of each number, but for the constant.
fn negative_log_likelihood(residual: Tensor<2>, log_sigma: Tensor<1>) -> Tensor<2> {
    let log_sigma = log_sigma.unsqueeze::<2>();
    residual.square() * (log_sigma.clone() * -2.0).exp() * 0.5 + log_sigma
}

/// `-E_q log N(e; mu_beta, s^2 I)` (Eq. 13, 14) of each view's own posterior, but for the constant.
///
/// On the invariant part: what turns is unknown where the view does not see it, so that pulling single views
/// together there would teach the encoder to say nothing.
fn instance_term(mean: Tensor<2>, precision: Tensor<2>, instance_means: Tensor<2>, sigma: f64) -> Tensor<1> {
    let variance = (precision.clone() + 1.0).recip();
    let posterior_mean = mean * precision * variance.clone();
    let squares = (posterior_mean - instance_means).square() + variance;
    squares.sum_dim(1).mean() * (0.5 / (sigma * sigma))
}
