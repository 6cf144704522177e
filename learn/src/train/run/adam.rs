//! Adam (Kingma and Ba 2015), in one pass over the numbers of a parameter; burn's own makes one for each operation. The
//! tests check it against that.

use crate::train::network::rows::floats;
use burn::module::{Module, ModuleMapper, Param};
use burn::optim::GradientsParams;
use burn::tensor::Tensor;
use vantage_dataset::widest::widest;

const DECAY: [f32; 2] = [0.9, 0.999];
const EPSILON: f32 = 1e-8;

/// The moments of all parameters, in the order in which a module shows them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Adam {
    moments: Vec<Moments>,
}

/// Of one parameter: how often it was moved, and decaying means of its gradients and of their squares.
#[derive(Clone, Debug, Default, PartialEq)]
struct Moments {
    steps: i32,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Adam {
    /// A module one step on; parameters without a gradient stay.
    pub(crate) fn step<M: Module>(&mut self, rate: f64, module: M, gradients: GradientsParams) -> M {
        module.map(&mut Step { adam: self, rate: rate as f32, gradients, parameter: 0 })
    }

    /// Of each parameter: steps and count as `u32`, then both moments as `f32`, little-endian.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for Moments { steps, first, second } in &self.moments {
            bytes.extend((*steps as u32).to_le_bytes());
            bytes.extend((first.len() as u32).to_le_bytes());
            bytes.extend(first.iter().chain(second).flat_map(|number| number.to_le_bytes()));
        }
        bytes
    }

    /// The inverse of [`Adam::to_bytes`]; `None` of bytes that are cut short.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut words = bytes.chunks_exact(4).map(|word| [word[0], word[1], word[2], word[3]]);
        let mut moments = Vec::new();
        while let Some(steps) = words.next() {
            let count = u32::from_le_bytes(words.next()?) as usize;
            let mut numbers = || {
                let numbers: Vec<f32> = words.by_ref().take(count).map(f32::from_le_bytes).collect();
                (numbers.len() == count).then_some(numbers)
            };
            let (first, second) = (numbers()?, numbers()?);
            moments.push(Moments { steps: u32::from_le_bytes(steps) as i32, first, second });
        }
        Some(Self { moments })
    }
}

impl Moments {
    fn move_on(&mut self, weights: &mut [f32], gradient: &[f32], rate: f32) {
        self.first.resize(weights.len(), 0.0);
        self.second.resize(weights.len(), 0.0);
        self.steps += 1;
        let [a, b] = DECAY;
        let (first_bias, second_bias) = (1.0 - a.powi(self.steps), 1.0 - b.powi(self.steps));
        widest(
            #[inline(always)]
            || {
                let moments = self.first.iter_mut().zip(&mut self.second);
                for ((weight, gradient), (first, second)) in weights.iter_mut().zip(gradient).zip(moments) {
                    *first = a * *first + (1.0 - a) * gradient;
                    *second = b * *second + (1.0 - b) * gradient * gradient;
                    *weight -= rate * (*first / first_bias) / ((*second / second_bias).sqrt() + EPSILON);
                }
            },
        );
    }
}

struct Step<'a> {
    adam: &'a mut Adam,
    rate: f32,
    gradients: GradientsParams,
    /// Place of the next parameter among all.
    parameter: usize,
}

impl ModuleMapper for Step<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let place = self.parameter;
        self.parameter += 1;
        if self.adam.moments.len() <= place {
            self.adam.moments.push(Moments::default());
        }
        let (id, tensor, mapper) = param.consume();
        let Some(gradient) = self.gradients.remove::<D>(id) else {
            return Param::from_mapped_value(id, tensor, mapper);
        };
        let device = tensor.device();
        let (mut weights, mut gradient) = (tensor.into_data(), gradient.into_data());
        self.adam.moments[place].move_on(floats(&mut weights), floats(&mut gradient), self.rate);
        let tensor = Tensor::<D>::from_data(weights, &device).require_grad();
        Param::from_mapped_value(id, tensor, mapper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::network::rows::numbers;
    use crate::train::run::device::cpu;
    use crate::train::run::scalar;
    use burn::nn::{Linear, LinearConfig};
    use burn::optim::AdamConfig;
    use burn::tensor::Tensor;

    fn gradients(layer: &Linear, x: &Tensor<2>) -> (f64, GradientsParams) {
        let loss = (layer.forward(x.clone()) - 1.0).square().mean();
        (scalar(&loss), GradientsParams::from_grads(loss.backward(), layer))
    }

    #[test]
    fn steps_are_those_of_burn() {
        let device = cpu();
        let x = Tensor::<2>::from_data([[0.3, -1.0, 2.0], [1.5, 0.2, -0.7]], &device);
        let (mut ours, mut adam) = (LinearConfig::new(3, 4).init(&device), Adam::default());
        let (mut theirs, mut reference) = (ours.clone(), AdamConfig::new().with_epsilon(1e-8).init());
        let first = gradients(&ours, &x).0;
        for _ in 0..30 {
            let gradient = gradients(&ours, &x).1;
            ours = adam.step(0.02, ours, gradient);
            let gradient = gradients(&theirs, &x).1;
            theirs = reference.step(0.02, theirs, gradient);
        }
        let (ours_weights, weights) = (numbers(ours.weight.val()), numbers(theirs.weight.val()));
        assert!(
            ours_weights.iter().zip(&weights).all(|(a, b)| (a - b).abs() < 1e-5),
            "{ours_weights:?} {weights:?}"
        );
        assert!(gradients(&ours, &x).0 < 0.5 * first);
        let bytes = adam.to_bytes();
        assert_eq!(Adam::from_bytes(&bytes), Some(adam));
        assert_eq!(Adam::from_bytes(&bytes[..bytes.len() - 4]), None);
    }
}
