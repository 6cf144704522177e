//! The networks, layer by layer: trunk, viewpoint head, encoder and decoder.

use super::convolution::{Convolutions, KERNEL, LayerGradient};
use super::features::Frozen;
use super::views::numbers;
use super::weights::{Conv, Dense, Weights};
use crate::architecture::{Architecture, CLASS_SHARPNESS, LOG_VARIANCE};
use crate::latent::LatentLayout;
use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::optim::GradientsParams;
use burn::tensor::activation::{relu, silu, softmax};
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::viewpoint::HARMONICS;
use vantage_dataset::{Seed, Stream};

/// Parameters of a convolution 4x4, stride 2, padding 1: see [`Convolutions`].
#[derive(Module, Debug)]
pub(crate) struct Convolution {
    /// `[outputs, 16 inputs]`.
    pub(super) weight: Param<Tensor<2>>,
    pub(super) bias: Param<Tensor<1>>,
}

/// `z` to features `t(z)`, and these to the reduced measurement `m(z)` of IV-C.
#[derive(Module, Debug)]
pub(crate) struct Trunk {
    pub(super) convolutions: Vec<Convolution>,
    features: Linear,
    measurement: Linear,
}

/// The trunk with the head that trains it: see [`super::trunk::Task`].
#[derive(Module, Debug)]
pub(crate) struct TrunkWithHead {
    pub(crate) trunk: Trunk,
    head: Vec<Linear>,
    /// From features to what tells instances apart, where the trunk learns that beside the viewpoint.
    embedding: Option<Linear>,
}

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

/// By how much each pair of a latent turns: cosine and sine of `m` times an angle, `[views, pairs]`; nothing for a latent
/// without pairs.
#[derive(Clone, Debug)]
pub(crate) struct Turn(Option<[Tensor<2>; 2]>);

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

impl Turn {
    /// From conditionings `[views, 2 HARMONICS..]` that begin with the harmonics.
    pub(crate) fn new(layout: LatentLayout, conditioning: &Tensor<2>) -> Self {
        if layout.pairs() == 0 {
            return Self(None);
        }
        let spread = |offset: usize| {
            let of_harmonic = |m: usize| {
                let column = conditioning.clone().narrow(1, 2 * m + offset, 1);
                column.repeat_dim(1, layout.pairs_per_harmonic)
            };
            Tensor::cat((0..HARMONICS).map(of_harmonic).collect(), 1)
        };
        Self(Some([spread(0), spread(1)]))
    }

    fn back(&self) -> Self {
        Self(self.0.clone().map(|[cos, sin]| [cos, sin.neg()]))
    }
}

impl Trunk {
    fn new(architecture: &Architecture, stream: &mut Stream, device: &Device) -> Self {
        let mut inputs = 3;
        let mut side = CROP_SIDE;
        let mut convolutions = Vec::new();
        for &outputs in &architecture.trunk {
            let taps = KERNEL * KERNEL * inputs;
            let weight = Param::from_data(uniform([outputs, taps], relu_bound(taps), stream), device);
            convolutions.push(Convolution { weight, bias: zeros(outputs, device) });
            (inputs, side) = (outputs, side / 2);
        }
        let features = linear(inputs * side * side, architecture.features, Gain::Relu, stream, device);
        let measurement =
            linear(architecture.features, architecture.measurement, Gain::Linear, stream, device);
        Self { convolutions, features, measurement }
    }

    /// The convolutions with their present weights.
    pub(crate) fn convolutions(&self) -> Convolutions {
        let numbers = |layer: &Convolution| (numbers(layer.weight.val()), numbers(layer.bias.val()));
        Convolutions::new(self.convolutions.iter().map(numbers))
    }

    /// `t(z)` of the convolutions' outputs, `[n, positions * channels]`.
    pub(crate) fn features(&self, convolved: Tensor<2>) -> Tensor<2> {
        relu(self.features.forward(convolved))
    }

    /// Adds what the convolutions' own backward pass gave to the gradients of a step.
    pub(crate) fn register(
        &self,
        layers: Vec<LayerGradient>,
        gradients: &mut GradientsParams,
        device: &Device,
    ) {
        for (layer, gradient) in self.convolutions.iter().zip(layers) {
            let shape = [gradient.bias.len(), gradient.weight.len() / gradient.bias.len()];
            let weight = TensorData::new(gradient.weight, shape);
            gradients.register(layer.weight.id, Tensor::<2>::from_data(weight, device));
            gradients.register(
                layer.bias.id,
                Tensor::<1>::from_data(TensorData::from(&gradient.bias[..]), device),
            );
        }
    }

    /// The convolutions and the layer after them, as numbers.
    pub(crate) fn layers(&self) -> (Vec<Conv>, Dense) {
        let conv = |layer: &Convolution| {
            let (weight, bias) = (numbers(layer.weight.val()), numbers(layer.bias.val()));
            Conv::new(&weight, bias)
        };
        let convolutions: Vec<_> = self.convolutions.iter().map(conv).collect();
        let channels = convolutions.last().map_or(3, |last| last.bias.len());
        (convolutions, dense(&self.features).with_channels_first(channels))
    }

    /// The layer from features to `m(z)`, not yet whitened, as numbers.
    pub(crate) fn measurement_layer(&self) -> Dense {
        dense(&self.measurement)
    }
}

impl TrunkWithHead {
    /// Fresh weights; `head` lists the numbers that go in and come out of each of the head's layers, `embedding` is how many
    /// tell instances apart.
    pub(crate) fn new(
        architecture: &Architecture,
        head: &[usize],
        embedding: Option<usize>,
        seed: Seed,
        device: &Device,
    ) -> Self {
        let stream = &mut seed.stream("trunk weights", 0);
        let trunk = Trunk::new(architecture, stream, device);
        let last = head.len().saturating_sub(2);
        let layer = |(index, sizes): (usize, &[usize])| {
            let gain = if index == last { Gain::Linear } else { Gain::Relu };
            linear(sizes[0], sizes[1], gain, stream, device)
        };
        let head = head.windows(2).enumerate().map(layer).collect();
        let embedding =
            embedding.map(|size| linear(architecture.features, size, Gain::Linear, stream, device));
        Self { trunk, head, embedding }
    }

    /// `m(z)` of features, not whitened.
    pub(crate) fn measure(&self, features: Tensor<2>) -> Tensor<2> {
        self.trunk.measurement.forward(features)
    }

    /// What tells instances apart, of features.
    pub(crate) fn embed(&self, features: Tensor<2>) -> Option<Tensor<2>> {
        self.embedding.as_ref().map(|layer| layer.forward(features))
    }

    /// What the head makes of measurements.
    pub(crate) fn answer(&self, mut x: Tensor<2>) -> Tensor<2> {
        for (index, layer) in self.head.iter().enumerate() {
            x = layer.forward(x);
            if index + 1 < self.head.len() {
                x = relu(x);
            }
        }
        x
    }
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

fn dense(layer: &Linear) -> Dense {
    let bias = layer.bias.as_ref().expect("every layer here has a bias");
    Dense { weight: numbers(layer.weight.val()), bias: numbers(bias.val()) }
}

/// A latent with each pair turned: into the object's frame by the azimuth, back by its negative.
pub(crate) fn turned(layout: LatentLayout, latents: Tensor<2>, turn: &Turn) -> Tensor<2> {
    let Turn(Some([cos, sin])) = turn else { return latents };
    let pairs = layout.pairs();
    let invariant = latents.clone().narrow(1, 0, layout.invariant);
    let first = latents.clone().narrow(1, layout.invariant, pairs);
    let second = latents.narrow(1, layout.invariant + pairs, pairs);
    let x = cos.clone() * first.clone() - sin.clone() * second.clone();
    let y = sin.clone() * first + cos.clone() * second;
    Tensor::cat(vec![invariant, x, y], 1)
}

/// Numbers for each of `[invariant | pairs]`, given to both of each pair: `[n, latent]`.
pub(crate) fn for_each_number(layout: LatentLayout, free: Tensor<2>) -> Tensor<2> {
    if layout.pairs() == 0 {
        return free;
    }
    let invariant = free.clone().narrow(1, 0, layout.invariant);
    let pairs = free.narrow(1, layout.invariant, layout.pairs());
    Tensor::cat(vec![invariant, pairs.clone(), pairs], 1)
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

enum Gain {
    /// He initialisation, for a layer that a ReLU follows.
    Relu,
    /// Keeps the variance.
    Linear,
}

fn relu_bound(inputs: usize) -> f64 {
    (6.0 / inputs as f64).sqrt()
}

fn linear(inputs: usize, outputs: usize, gain: Gain, stream: &mut Stream, device: &Device) -> Linear {
    let bound = match gain {
        Gain::Relu => relu_bound(inputs),
        Gain::Linear => (3.0 / inputs as f64).sqrt(),
    };
    let weight = Param::from_data(uniform([inputs, outputs], bound, stream), device);
    Linear { weight, bias: Some(zeros(outputs, device)) }
}

/// An encoder's last layer whose variances are the largest that a factor may have, whatever it sees.
fn of_fixed_variance(layer: Linear, means: usize, device: &Device) -> Linear {
    let Dense { mut weight, mut bias } = dense(&layer);
    let outputs = bias.len();
    weight.chunks_exact_mut(outputs).for_each(|row| row[means..].fill(0.0));
    bias[means..].fill(2.0 * LOG_VARIANCE.1);
    let shape = [weight.len() / outputs, outputs];
    Linear {
        weight: Param::from_data(TensorData::new(weight, shape), device),
        bias: Some(Param::from_data(TensorData::new(bias, [outputs]), device)),
    }
}

fn uniform<const D: usize>(shape: [usize; D], bound: f64, stream: &mut Stream) -> TensorData {
    let volume = shape.iter().product();
    let values: Vec<f32> = (0..volume).map(|_| stream.uniform(-bound, bound) as f32).collect();
    TensorData::new(values, shape)
}

fn zeros(size: usize, device: &Device) -> Param<Tensor<1>> {
    Param::from_data(TensorData::new(vec![0f32; size], [size]), device)
}
