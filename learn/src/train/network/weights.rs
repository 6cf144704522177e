//! Trained weights as plain numbers: what the ONNX graphs are written from.

use crate::architecture::Architecture;
use std::ops::Range;

/// A linear layer `y = x W + b`.
#[derive(Clone)]
pub(crate) struct Dense {
    /// `W`, `[inputs, outputs]`, row-major.
    pub weight: Vec<f32>,
    /// `b`, `[outputs]`.
    pub bias: Vec<f32>,
}

impl Dense {
    pub(crate) fn outputs(&self) -> usize {
        self.bias.len()
    }

    pub(crate) fn inputs(&self) -> usize {
        self.weight.len() / self.bias.len()
    }

    /// `W^T`, `[outputs, inputs]`, row-major.
    pub(crate) fn transposed(&self) -> Vec<f32> {
        self.transposed_of(0..self.inputs())
    }

    /// The layer that gives some of the outputs.
    pub(crate) fn columns(&self, columns: impl IntoIterator<Item = usize>) -> Self {
        let columns: Vec<usize> = columns.into_iter().collect();
        let taken = |row: &[f32]| columns.iter().map(|&column| row[column]).collect::<Vec<_>>();
        Self { weight: self.weight.chunks(self.outputs()).flat_map(taken).collect(), bias: taken(&self.bias) }
    }

    /// The part of the weight that takes some of the inputs: `W^T`, `[outputs, inputs]`, row-major.
    pub(crate) fn transposed_of(&self, inputs: Range<usize>) -> Vec<f32> {
        let outputs = 0..self.outputs();
        let column = |output| inputs.clone().map(move |input| self.weight[input * self.outputs() + output]);
        outputs.flat_map(column).collect()
    }

    /// This layer, which takes pixels of `channels` numbers each, taking channels of pixels instead.
    pub(crate) fn with_channels_first(mut self, channels: usize) -> Self {
        let (rows, columns) = (self.inputs(), self.outputs());
        let pixels = rows / channels;
        let row = |row: usize| {
            let from = (row % pixels) * channels + row / pixels;
            &self.weight[from * columns..(from + 1) * columns]
        };
        self.weight = (0..rows).flat_map(row).copied().collect();
        self
    }
}

/// Side of a kernel; kernels move by 2 and reach 1 pixel beyond the border.
pub(crate) const KERNEL: usize = 4;

/// A convolution 4x4, stride 2, padding 1.
pub(crate) struct Conv {
    /// `[outputs, inputs, 4, 4]`, row-major.
    pub weight: Vec<f32>,
    /// `[outputs]`.
    pub bias: Vec<f32>,
}

impl Conv {
    /// From a weight `[outputs, 4, 4, inputs]`.
    pub(crate) fn new(weight: &[f32], bias: Vec<f32>) -> Self {
        let taps = KERNEL * KERNEL;
        let inputs = weight.len() / bias.len() / taps;
        let moved = |index: usize| {
            let (output, input, tap) = (index / taps / inputs, index / taps % inputs, index % taps);
            weight[(output * taps + tap) * inputs + input]
        };
        Self { weight: (0..weight.len()).map(moved).collect(), bias }
    }
}

/// All that is trained, and the fixed basis of crops.
pub(crate) struct Weights {
    pub architecture: Architecture,
    /// Whether an embedding is a direction.
    pub unit_embedding: bool,
    /// Convolutions of the trunk.
    pub trunk: Vec<Conv>,
    /// The trunk's last layer: last convolution, flattened by channel, row, column, to `t(z)`.
    pub features: Dense,
    /// `t(z)` to the whitened `m(z)`.
    pub measurement: Dense,
    /// Crop `[3, 32, 32]` to its image coefficients.
    pub projection: Dense,
    /// What `t(z)` is centred by before the encoder.
    pub feature_mean: Vec<f32>,
    /// What the centred `t(z)` is multiplied by.
    pub feature_scale: Vec<f32>,
    /// Standardised `t(z)` and upright conditioning to mean, log variance of the invariant part and of the pairs.
    pub encoder: Vec<Dense>,
    /// Latent in the camera's yaw frame and conditioning to hidden features.
    pub decoder: Vec<Dense>,
    /// Hidden features to `m(e, x)`.
    pub decoded_measurement: Dense,
    /// Hidden features to the coefficients of a crop.
    pub decoded_image: Dense,
    /// Crop `[3, 32, 32]` of all coefficients 0, and the crops that the coefficients weigh, `[components, 3072]`.
    pub basis: Dense,
}
