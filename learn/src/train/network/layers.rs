//! Linear layers: fresh weights, and weights as plain numbers.

use super::LOG_VARIANCE;
use super::rows::numbers;
use super::weights::Dense;
use burn::module::Param;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::Stream;

/// What the weights of a fresh layer are scaled for.
pub(crate) enum Gain {
    /// He initialisation, for a layer that a ReLU follows.
    Relu,
    /// Keeps the variance.
    Linear,
}

pub(crate) fn relu_bound(inputs: usize) -> f64 {
    (6.0 / inputs as f64).sqrt()
}

pub(crate) fn linear(
    inputs: usize,
    outputs: usize,
    gain: Gain,
    stream: &mut Stream,
    device: &Device,
) -> Linear {
    let bound = match gain {
        Gain::Relu => relu_bound(inputs),
        Gain::Linear => (3.0 / inputs as f64).sqrt(),
    };
    let weight = Param::from_data(uniform([inputs, outputs], bound, stream), device);
    Linear { weight, bias: Some(zeros(outputs, device)) }
}

/// An encoder's last layer whose variances are the largest that a factor may have, whatever it sees.
pub(crate) fn of_fixed_variance(layer: Linear, means: usize, device: &Device) -> Linear {
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

pub(crate) fn uniform<const D: usize>(shape: [usize; D], bound: f64, stream: &mut Stream) -> TensorData {
    let volume = shape.iter().product();
    let values: Vec<f32> = (0..volume).map(|_| stream.uniform(-bound, bound) as f32).collect();
    TensorData::new(values, shape)
}

pub(crate) fn zeros(size: usize, device: &Device) -> Param<Tensor<1>> {
    Param::from_data(TensorData::new(vec![0f32; size], [size]), device)
}

/// A layer as numbers.
pub(crate) fn dense(layer: &Linear) -> Dense {
    let bias = layer.bias.as_ref().expect("every layer here has a bias");
    Dense { weight: numbers(layer.weight.val()), bias: numbers(bias.val()) }
}
