//! Weights rounded to half precision, as the graphs store them: what is calibrated and replayed is then what is run.

use super::rows::numbers;
use super::weights::Dense;
use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Tensor, TensorData};
use half::f16;

/// Numbers as half precision holds them.
pub(crate) fn rounded(numbers: &[f32]) -> Vec<f32> {
    numbers.iter().map(|&number| f16::from_f32(number).to_f32()).collect()
}

/// A layer with its matrix rounded.
pub(crate) fn rounded_layer(layer: Dense) -> Dense {
    Dense { weight: rounded(&layer.weight), bias: layer.bias }
}

/// A module with all its matrices rounded; vectors stay.
pub(crate) fn rounded_module<M: Module>(module: M) -> M {
    module.map(&mut Rounding)
}

struct Rounding;

impl ModuleMapper for Rounding {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        if D < 2 {
            return param;
        }
        let (id, tensor, mapper) = param.consume();
        let (shape, device, learned) = (tensor.dims(), tensor.device(), tensor.is_require_grad());
        let data = TensorData::new(rounded(&numbers(tensor)), shape);
        let tensor = Tensor::<D>::from_data(data, &device).set_require_grad(learned);
        Param::from_mapped_value(id, tensor, mapper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::nn::LinearConfig;
    use burn::tensor::Device;

    #[test]
    fn matrices_become_what_half_precision_holds_and_vectors_stay() {
        let mut layer = LinearConfig::new(2, 2).init(&Device::flex());
        let device = Device::flex();
        layer.weight = Param::from_data(TensorData::new(vec![0.1f32, 1.0, -3.0, 1e-9], [2, 2]), &device);
        layer.bias = Some(Param::from_data(TensorData::new(vec![0.1f32, 0.3], [2]), &device));
        let layer = rounded_module(layer);
        let weight = numbers(layer.weight.val());
        assert!(weight[0] != 0.1 && (weight[0] - 0.1).abs() < 1e-4, "{weight:?}");
        assert_eq!(weight[1..], [1.0, -3.0, 0.0]);
        assert_eq!(numbers(layer.bias.unwrap().val()), [0.1, 0.3]);
    }
}
