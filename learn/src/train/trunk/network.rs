//! The networks of stage 1: trunk and heads.

use super::convolution::{Convolutions, LayerGradient};
use crate::architecture::Architecture;
use crate::train::network::layers::{Gain, dense, linear, relu_bound, uniform, zeros};
use crate::train::network::rows::numbers;
use crate::train::network::weights::{Conv, Dense, KERNEL};
use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::optim::GradientsParams;
use burn::tensor::activation::relu;
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::crop::CROP_SIDE;
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

/// The trunk with what trains it: the head of a [`Task`](crate::spec::Task) and, perhaps, a projection to embeddings.
#[derive(Module, Debug)]
pub(crate) struct TrunkWithHead {
    pub(crate) trunk: Trunk,
    head: Vec<Linear>,
    /// From features to embeddings, by which instances are told apart.
    embedding: Option<Linear>,
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

    /// Embeddings of features; `None` where the trunk learns its task alone.
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
