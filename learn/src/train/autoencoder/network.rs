//! The networks of stage 2: encoder and decoder.

use super::features::Frozen;
use crate::architecture::Architecture;
use crate::latent::LatentLayout;
use crate::train::network::exponential::silu;
use crate::train::network::layers::{Gain, dense, linear, of_fixed_variance, zeros};
use crate::train::network::turn::{Turn, turned};
use crate::train::network::weights::Weights;
use crate::train::network::{CLASS_SHARPNESS, LOG_VARIANCE};
use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::activation::{relu, softmax};
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::Seed;
use vantage_dataset::viewpoint::HARMONICS;

/// Encoder `q`, decoder `p`, and the parameters of their likelihoods and of the instance term.
#[derive(Module, Debug)]
pub(crate) struct Autoencoder {
    encoder: Vec<Linear>,
    decoder: Vec<Linear>,
    measurement: Linear,
    image: Linear,
    /// `mu_beta` of Eq. 14, invariant part, `[instances, invariant]`.
    pub(crate) instance_means: Param<Tensor<2>>,
    /// Means of `P(e | c)` of Eq. 23, invariant part, `[classes, invariant]`; one row where there are no classes.
    pub(crate) class_means: Param<Tensor<2>>,
    /// Logarithm of the standard deviation of each number of `m`.
    pub(crate) log_sigma_measurement: Param<Tensor<1>>,
    /// Logarithm of the standard deviation of each image coefficient.
    pub(crate) log_sigma_image: Param<Tensor<1>>,
}

/// A view's factor on the latent, object frame: mean `[views, latent]`, log variance `[views, invariant + pairs]`.
pub(crate) struct Factor {
    pub(crate) mean: Tensor<2>,
    pub(crate) log_variance: Tensor<2>,
}

/// What a decoder says: `[views, measurement]` and `[views, components]`.
pub(crate) struct Decoded {
    pub(crate) measurement: Tensor<2>,
    pub(crate) image: Tensor<2>,
}

impl Autoencoder {
    /// Fresh weights.
    pub(crate) fn new(
        architecture: &Architecture,
        [instances, classes]: [usize; 2],
        seed: Seed,
        device: &Device,
    ) -> Self {
        let stream = &mut seed.stream("autoencoder weights", 0);
        let latent = architecture.latent;
        let mut hidden = |inputs: usize, sizes: &[usize]| {
            let mut inputs = inputs;
            let mut layers = Vec::new();
            for &outputs in sizes {
                layers.push(linear(inputs, outputs, Gain::Relu, stream, device));
                inputs = outputs;
            }
            (layers, inputs)
        };
        let (mut encoder, encoded) = hidden(
            architecture.features + architecture.components + architecture.encoder_conditioning(),
            &architecture.encoder,
        );
        let (decoder, decoded) = hidden(architecture.decoder_inputs(), &architecture.decoder);
        let gaussian = latent.dimension() + latent.invariant + latent.pairs();
        encoder.push(linear(encoded, gaussian, Gain::Linear, stream, device));
        if architecture.latent_is_class {
            let last = encoder.pop().expect("it was just added");
            encoder.push(of_fixed_variance(last, latent.dimension(), device));
        }
        let means = |rows: usize| {
            let data = TensorData::new(vec![0f32; rows * latent.invariant], [rows, latent.invariant]);
            Param::from_data(data, device)
        };
        Self {
            encoder,
            decoder,
            measurement: linear(decoded, architecture.measurement, Gain::Linear, stream, device),
            image: linear(decoded, architecture.components, Gain::Linear, stream, device),
            instance_means: means(instances),
            class_means: means(classes.max(1)),
            log_sigma_measurement: zeros(architecture.measurement, device),
            log_sigma_image: zeros(architecture.components, device),
        }
    }

    /// `q(e | z, x_rel)` of what [`Architecture::encoder_conditioning`] and [`super::features::Features::crop`] give,
    /// `[n, features + components + conditioning]`, turned into the frame of the conditioning.
    pub(crate) fn encode(&self, layout: LatentLayout, inputs: Tensor<2>, turn: &Turn) -> Factor {
        let mut x = inputs;
        let (last, hidden) = self.encoder.split_last().expect("an encoder has a last layer");
        for layer in hidden {
            x = relu(layer.forward(x));
        }
        let out = last.forward(x);
        let (latent, free) = (layout.dimension(), layout.invariant + layout.pairs());
        let log_variance = out.clone().narrow(1, latent, free).clamp(LOG_VARIANCE.0, LOG_VARIANCE.1);
        Factor { mean: turned(layout, out.narrow(1, 0, latent), turn), log_variance }
    }

    /// `p(. | e, x_rel)` of latents `[n, latent]` and what the decoder sees beside them, if anything.
    pub(crate) fn decode(
        &self,
        architecture: &Architecture,
        latents: Tensor<2>,
        seen: Option<Tensor<2>>,
        turn: &Turn,
    ) -> Decoded {
        let mut x = turned(architecture.latent, latents, &turn.back());
        if architecture.latent_is_class {
            x = softmax(x * CLASS_SHARPNESS, 1);
        }
        if let Some(seen) = seen {
            x = Tensor::cat(vec![x, seen], 1);
        }
        for layer in &self.decoder {
            x = silu(layer.forward(x));
        }
        Decoded { measurement: self.measurement.forward(x.clone()), image: self.image.forward(x) }
    }

    /// All weights, with those of the frozen trunk, as numbers.
    pub(crate) fn weights(
        &self,
        architecture: &Architecture,
        frozen: &Frozen,
        unit_embedding: bool,
    ) -> Weights {
        let (trunk, features) = frozen.trunk.layers();
        Weights {
            architecture: architecture.clone(),
            unit_embedding,
            trunk,
            features,
            measurement: frozen.measurement.clone(),
            feature_mean: frozen.mean.clone(),
            feature_scale: frozen.scale.clone(),
            encoder: self.encoder.iter().map(dense).collect(),
            decoder: self.decoder.iter().map(dense).collect(),
            decoded_measurement: dense(&self.measurement),
            decoded_image: dense(&self.image),
            projection: frozen.components.projection.clone(),
            basis: frozen.components.layer.clone(),
        }
    }
}

/// What the encoder sees: crops as [`super::features::Features::crop`] gives them, and the upright part of conditionings by
/// viewpoint.
pub(crate) fn encoder_input(
    architecture: &Architecture,
    crops: Tensor<2>,
    conditioning: &Tensor<2>,
) -> Tensor<2> {
    match architecture.encoder_conditioning() {
        0 => crops,
        upright => Tensor::cat(vec![crops, conditioning.clone().narrow(1, 2 * HARMONICS, upright)], 1),
    }
}

/// What the decoder sees beside latents: the end of the conditionings, then the source's measurements.
pub(crate) fn decoder_input(
    architecture: &Architecture,
    conditioning: &Tensor<2>,
    source: Option<Tensor<2>>,
) -> Option<Tensor<2>> {
    let (width, seen) = (architecture.conditioning(), architecture.decoder_conditioning());
    let seen = (seen > 0).then(|| conditioning.clone().narrow(1, width - seen, seen));
    let parts: Vec<_> = seen.into_iter().chain(source.filter(|_| architecture.decoder_sees_source)).collect();
    (!parts.is_empty()).then(|| Tensor::cat(parts, 1))
}
