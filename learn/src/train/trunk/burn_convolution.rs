//! The trunk's convolutions as burn has them: the faster ones on a GPU.

use super::network::Trunk;
use crate::train::network::PIXEL_CENTER;
use crate::train::network::weights::KERNEL;
use burn::tensor::activation::relu;
use burn::tensor::module::conv2d;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;

/// What [`Convolutions`](super::convolution::Convolutions) give, `[n, positions * channels]`, with derivatives.
pub(crate) fn convolved(trunk: &Trunk, crops: &[&Crop], device: &Device) -> Tensor<2> {
    let planes: Vec<f32> = crops.iter().flat_map(|crop| crop.to_chw()).collect();
    let shape = [crops.len(), 3, CROP_SIDE, CROP_SIDE];
    let mut x = Tensor::<4>::from_data(TensorData::new(planes, shape), device) - PIXEL_CENTER;
    for convolution in &trunk.convolutions {
        x = layer(x, convolution.weight.val(), convolution.bias.val());
    }
    x.permute([0, 2, 3, 1]).flatten(1, 3)
}

/// `relu(conv(x))` of `[n, inputs, side, side]`; the weight is `[outputs, 16 inputs]`: kernel row, kernel column, channel.
pub(crate) fn layer(x: Tensor<4>, weight: Tensor<2>, bias: Tensor<1>) -> Tensor<4> {
    let [outputs, inputs] = [weight.dims()[0], x.dims()[1]];
    let weight = weight.reshape([outputs, KERNEL, KERNEL, inputs]).permute([0, 3, 1, 2]);
    relu(conv2d(x, weight, Some(bias), ConvOptions::new([2, 2], [1, 1], [1, 1], 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::architecture::Architecture;
    use crate::spec::TrainingSpec;
    use crate::train::network::rows::numbers;
    use crate::train::synthetic;
    use crate::train::trunk::network::TrunkWithHead;
    use vantage_dataset::{Seed, Split};

    #[test]
    fn they_give_what_the_own_ones_give() {
        let device = Device::flex();
        let architecture = Architecture::new(&TrainingSpec::default()).unwrap();
        let trunk = TrunkWithHead::new(&architecture, &[32, 2], None, Seed(1), &device).trunk;
        let set = synthetic::views(Split::Train, 3, 2, 1);
        let crops: Vec<&Crop> = set.views.iter().map(|view| &view.crop).collect();
        let own = trunk.convolutions().pass(&crops).outputs();
        let burns = numbers(convolved(&trunk, &crops, &device));
        assert!(own.len() == burns.len() && own.iter().any(|x| *x > 0.01));
        assert!(own.iter().zip(&burns).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
