//! Stage 2: encoder and decoder by the evidence lower bounds of Eq. 12 and Eq. 20, for several views at once.
//!
//! For views `1..=V` of one instance, of which the first `K` are encoded,
//! `log p(z_1..z_V, beta | x_1..x_V) >= sum_v E_q log p(z_v | e, x_v) - KL(q || N(0, I)) + log p(e | beta)` with
//! `q(e | z_1..z_K, x_1..x_K)` the product of the encoder's factors and the prior. With `V = K = 1` it is Eq. 12.
//!
//! Eq. 13 has `P(beta | e)` where Eq. 14 has `p(e | beta)`: see [`instance_term`].
//!
//! The predictive bound is the same in the frame of the first view, with `x_v` the change from that to view `v` and, for
//! some, `z_1` beside it: `p(z_v | e, z_1, Delta X)`; `p(z_1 | e)` is its term `v = 1`. With `V = 2, K = 1` it is Eq. 20.

pub(crate) mod contrastive;
pub(crate) mod discrete_class;
pub(crate) mod features;
mod instance_term;
pub(crate) mod network;

use crate::architecture::Architecture;
use crate::spec::{InstanceTerm, Loss, Pairs, TrainingSpec};
use crate::train::data::views::Views;
use crate::train::network::exponential::exp;
use crate::train::network::rows::{rows_of, table};
use crate::train::network::turn::{Turn, for_each_number};
use crate::train::run::{Step, scalar};
use burn::module::Module;
use burn::optim::{GradientsAccumulator, GradientsParams};
use burn::tensor::{Device, Tensor, TensorData};
use features::Features;
use instance_term::Alone;
use network::{Autoencoder, decoder_input, encoder_input};
use rayon::prelude::*;
use vantage_dataset::{Seed, Stream};

/// Share of the steps over which the divergence and the instance term come in: with their full weight from the start,
/// a decoder that does not know the latent yet teaches the encoder to say nothing.
const WARM_UP: f64 = 0.3;
/// Parts that a batch's gradient is the sum of, each computed on its own, whatever the number of threads.
const PARTS: usize = 2;
/// Random instances that stand for all others where a part's posterior over instances is normalised.
const OTHERS: usize = 256;

/// Views of some instances, as many of each: rows are instance by instance.
struct Batch {
    per_group: usize,
    /// Index of each row's instance.
    instances: Vec<i64>,
    /// View of each row.
    views: Vec<usize>,
    /// 1 for rows that are encoded, 0 for those that are only predicted.
    encoded: Vec<f32>,
    /// The view in whose frame a row is predicted.
    source: Vec<usize>,
    /// Whether its measurement is shown to the decoder.
    sourced: Vec<bool>,
    /// Standard normal draws, `[groups, latent]`.
    noise: Vec<f32>,
    /// Random instances, which stand for all that a row is not of.
    others: Vec<i64>,
}

impl Batch {
    /// A part of the random batch of a step.
    fn draw(bound: &Bound, index: usize, part: usize) -> Self {
        let Bound { views, spec, architecture, seed, .. } = bound;
        let mut stream = seed.stream("autoencoder batch", (index * PARTS + part) as u64);
        let alone = spec.traits().loss == Loss::BoundOfSingles;
        let (count, per_group) = match (spec.batch as usize, spec.views as usize) {
            (batch, views) if alone => (batch * views, 1),
            sizes => sizes,
        };
        let count = (part + 1) * count / PARTS - part * count / PARTS;
        let mut batch = Self {
            per_group,
            instances: Vec::new(),
            views: Vec::new(),
            encoded: Vec::new(),
            source: Vec::new(),
            sourced: Vec::new(),
            noise: Vec::new(),
            others: Vec::new(),
        };
        let adjacent = spec.reads_odometry() && spec.predictive.pairs == Pairs::Adjacent;
        for _ in 0..count {
            let group = &views.groups[stream.below(views.groups.len())];
            let order = chosen(&group.views, per_group, adjacent, &mut stream);
            let most = order.len().min(per_group).min(spec.context as usize);
            let encoded = 1 + stream.below(most);
            for row in 0..per_group {
                let view = order[row % order.len()];
                batch.instances.push(group.instance as i64);
                batch.views.push(view);
                batch.encoded.push(if row < encoded { 1.0 } else { 0.0 });
                batch.source.push(order[0]);
                let other = architecture.decoder_sees_source && view != order[0];
                batch.sourced.push(other && stream.chance(spec.predictive.source));
            }
        }
        batch.noise.extend((0..count * architecture.latent.dimension()).map(|_| stream.normal() as f32));
        if spec.instance_term == InstanceTerm::Posterior {
            batch.others.extend((0..OTHERS).map(|_| stream.below(views.instances) as i64));
        }
        batch
    }

    fn groups(&self) -> usize {
        self.views.len() / self.per_group
    }
}

/// Views in random order, or a stretch of `count` along the way.
fn chosen(views: &[usize], count: usize, adjacent: bool, stream: &mut Stream) -> Vec<usize> {
    if adjacent {
        let count = count.min(views.len());
        let start = stream.below(views.len() - count + 1);
        return views[start..start + count].to_vec();
    }
    let mut order = views.to_vec();
    stream.shuffle(&mut order);
    order
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

/// The negative bound of the random batch of a step, a view, its image and instance terms weighted.
pub(crate) fn step(network: &Autoencoder, bound: &Bound, index: usize) -> Step<4> {
    // Copies that share no node with each other: burn works on the graphs of one parameter one after the other.
    let plain = network.valid();
    let networks: Vec<Autoencoder> = (0..PARTS).map(|_| plain.clone().train()).collect();
    let parts: Vec<Step<4>> = networks
        .into_par_iter()
        .enumerate()
        .map(|(part, network)| part_step(&network, bound, index, part))
        .collect();
    let mut accumulator = GradientsAccumulator::new();
    let (mut loss, mut terms) = (0.0, [0.0; 4]);
    for part in parts {
        accumulator.accumulate(network, part.gradients);
        loss += part.loss;
        terms.iter_mut().zip(part.terms).for_each(|(sum, term)| *sum += term);
    }
    Step { loss, terms, gradients: accumulator.grads() }
}

/// A part of the batch, its loss as a share of the whole.
fn part_step(network: &Autoencoder, bound: &Bound, index: usize, part: usize) -> Step<4> {
    let Bound { views, features, spec, architecture, device, .. } = *bound;
    let layout = architecture.latent;
    let dimension = layout.dimension();
    let batch = Batch::draw(bound, index, part);
    let (count, per_group, rows) = (batch.groups(), batch.per_group, batch.views.len());

    let conditioning = (0..rows).flat_map(|row| {
        views.conditioning(architecture.convention, batch.source[row], batch.views[row], batch.sourced[row])
    });
    let conditioning = table(conditioning.collect(), rows, device);
    let turn = Turn::new(layout, &conditioning);
    let inputs = encoder_input(architecture, features.crop(&batch.views, device), &conditioning);
    let factor = network.encode(layout, inputs, &turn);
    let precision = exp(factor.log_variance.neg());

    let encoded = Tensor::<2>::from_data(TensorData::new(batch.encoded, [rows, 1]), device);
    let informed = for_each_number(layout, precision.clone() * encoded);
    let over_views = |tensor: Tensor<2>| tensor.reshape([count, per_group, dimension]).sum_dim(1);
    let weighted = over_views(informed.clone() * factor.mean.clone());
    let variance = (over_views(informed) + 1.0).recip();
    let mean = weighted * variance.clone();
    let noise = Tensor::<3>::from_data(TensorData::new(batch.noise, [count, 1, dimension]), device);
    let latent = mean.clone() + variance.clone().sqrt() * noise;

    let latents = latent.expand([count, per_group, dimension]).reshape([rows, dimension]);
    let source = architecture.decoder_sees_source.then(|| {
        let shown: Vec<f32> = batch.sourced.iter().map(|&sourced| f32::from(u8::from(sourced))).collect();
        features.measurement(&batch.source, device) * table(shown, rows, device)
    });
    let seen = decoder_input(architecture, &conditioning, source);
    let decoded = network.decode(architecture, latents, seen, &turn);
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
    let warm = (((index + 1) as f64) / (WARM_UP * f64::from(spec.steps))).min(1.0);
    let mut total = measurement.clone() + image.clone() * spec.image_weight + divergence.clone() * warm;
    let invariant = |tensor: Tensor<2>| tensor.narrow(1, 0, layout.invariant);
    let alone = Alone::new(invariant(factor.mean), invariant(precision));
    let mut grouping = 0.0;
    if spec.instance_weight > 0.0 && spec.traits().loss != Loss::BoundOfSingles {
        let (means, own) = (network.instance_means.val(), &batch.instances);
        let term = match spec.instance_term {
            InstanceTerm::Likelihood => alone.unlikelihood(rows_of(&means, own, device), spec.instance_sigma),
            InstanceTerm::Posterior => {
                alone.surprise(&means, own, &batch.others, spec.instance_sigma, device)
            }
        };
        let term = term.mean();
        grouping += scalar(&term);
        total = total + term * (warm * spec.instance_weight);
    }
    if let Some(class) = &spec.class {
        let tags: Vec<Option<usize>> =
            batch.instances.iter().map(|&instance| views.tags[instance as usize]).collect();
        let classes: Vec<i64> = tags.iter().map(|tag| tag.unwrap_or(0) as i64).collect();
        let means = rows_of(&network.class_means.val(), &classes, device);
        let tagged = tags.iter().map(|tag| if tag.is_some() { 1.0 } else { 0.0 }).collect();
        let term = (alone.unlikelihood(means, class.sigma) * table(tagged, rows, device)).mean();
        grouping += scalar(&term);
        total = total + term * warm;
    }
    let share = rows as f64 / f64::from(spec.batch * spec.views);
    let total = total * share;
    let terms =
        [scalar(&measurement), scalar(&image), scalar(&divergence), grouping].map(|term| term * share);
    let loss = scalar(&total);
    Step { loss, terms, gradients: GradientsParams::from_grads(total.backward(), network) }
}

/// `-log N(residual; 0, sigma^2)` of each number, but for the constant.
pub(crate) fn negative_log_likelihood(residual: Tensor<2>, log_sigma: Tensor<1>) -> Tensor<2> {
    let log_sigma = log_sigma.unsqueeze::<2>();
    residual.square() * (log_sigma.clone() * -2.0).exp() * 0.5 + log_sigma
}
