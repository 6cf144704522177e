//! The trainer's own outputs, which every loader replays.

use super::features::{Features, Frozen};
use super::network::{Autoencoder, Turn, for_each_number, seen, upright};
use super::views::{Views, numbers};
use crate::architecture::Architecture;
use crate::canary::{Canary, CanaryCase, TOLERANCE};
use crate::role::Role;
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::viewpoint::CONDITIONING;

/// Views replayed.
const VIEWS: usize = 2;

/// All that computes a canary; `network` and `device` with derivatives.
pub(crate) struct Trainer<'a> {
    pub(crate) network: &'a Autoencoder,
    pub(crate) architecture: &'a Architecture,
    pub(crate) frozen: &'a Frozen,
    pub(crate) features: &'a Features,
    pub(crate) views: &'a Views<'a>,
    pub(crate) device: &'a Device,
}

impl Trainer<'_> {
    /// Each graph's run on a view of the first and of the last instance, latents from the view itself.
    pub(crate) fn canary(&self) -> Canary {
        let last = self.views.len() - 1;
        let chosen = (0..VIEWS).map(|i| i * last / (VIEWS - 1));
        Canary { tolerance: TOLERANCE, cases: chosen.flat_map(|view| self.cases(view)).collect() }
    }

    fn cases(&self, view: usize) -> Vec<CanaryCase> {
        let layout = self.architecture.latent;
        let conditioning = self.features.conditioning(&[view], self.device);
        let turn = Turn::new(layout, &conditioning);
        let crop = self.views.set.views[view].crop.to_chw();
        let x = self.views.conditioning(view).to_vec();

        let measurement = numbers(self.features.measurement(&[view], self.device));
        let features = self.features.crop(&[view], self.device);
        let factor = self.network.encode(layout, features, upright(conditioning.clone()), &turn);
        let mean = numbers(factor.mean.clone());
        let log_variance = numbers(for_each_number(layout, factor.log_variance));
        let seen = seen(self.architecture, conditioning);
        let decoded = self.network.decode(layout, factor.mean, seen, &turn);
        let predicted = numbers(decoded.measurement);
        let image = self.pixels(&numbers(decoded.image));
        let (d_latent, d_conditioning) = self.jacobian(&mean, &x);

        let case = |role, inputs: [&Vec<f32>; 2], outputs: &[&Vec<f32>]| CanaryCase {
            role,
            inputs: inputs.into_iter().filter(|input| !input.is_empty()).cloned().collect(),
            outputs: outputs.iter().map(|&output| output.clone()).collect(),
        };
        vec![
            case(Role::Measurement, [&crop, &Vec::new()], &[&measurement]),
            case(Role::Encoder, [&crop, &x], &[&mean, &log_variance]),
            case(Role::Decoder, [&mean, &x], &[&predicted]),
            case(Role::DecoderJacobian, [&mean, &x], &[&predicted, &d_latent, &d_conditioning]),
            case(Role::Image, [&mean, &x], &[&image]),
        ]
    }

    /// Row by row through the trainer's automatic derivatives.
    fn jacobian(&self, latent: &[f32], x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let layout = self.architecture.latent;
        let input = |row: &[f32]| {
            let data = TensorData::new(row.to_vec(), [1, row.len()]);
            Tensor::<2>::from_data(data, self.device).require_grad()
        };
        let (mut d_latent, mut d_conditioning) = (Vec::new(), Vec::new());
        for row in 0..self.architecture.measurement {
            let (latent, conditioning) = (input(latent), input(x));
            let turn = Turn::new(layout, &conditioning);
            let seen = seen(self.architecture, conditioning.clone());
            let decoded = self.network.decode(layout, latent.clone(), seen, &turn);
            let gradients = decoded.measurement.narrow(1, row, 1).sum().backward();
            let of = |input: &Tensor<2>, width: usize| {
                input.grad(&gradients).map_or_else(|| vec![0.0; width], numbers)
            };
            d_latent.extend(of(&latent, layout.dimension()));
            d_conditioning.extend(of(&conditioning, CONDITIONING));
        }
        (d_latent, d_conditioning)
    }

    fn pixels(&self, coefficients: &[f32]) -> Vec<f32> {
        let layer = self.frozen.components.layer();
        let mut pixels = layer.bias.clone();
        for (weights, coefficient) in layer.weight.chunks_exact(pixels.len()).zip(coefficients) {
            pixels.iter_mut().zip(weights).for_each(|(pixel, weight)| *pixel += coefficient * weight);
        }
        pixels.into_iter().map(|pixel| pixel.clamp(0.0, 1.0)).collect()
    }
}
