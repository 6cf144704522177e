//! The trainer's own outputs, which every loader replays.

use crate::architecture::Architecture;
use crate::canary::{Canary, CanaryCase, TOLERANCE};
use crate::role::{Kind, Role};
use crate::train::autoencoder::features::{Features, Frozen};
use crate::train::autoencoder::network::{Autoencoder, decoder_input, encoder_input};
use crate::train::data::views::Views;
use crate::train::export::roles;
use crate::train::network::LOG_VARIANCE;
use crate::train::network::rows::{numbers, table};
use crate::train::network::turn::{Turn, for_each_number};
use crate::train::trunk::info_nce::normalized;
use burn::tensor::{Device, Tensor, TensorData};

/// Views replayed.
const VIEWS: usize = 2;

/// All that computes a canary; `network` and `device` with derivatives.
pub(crate) struct Trainer<'a> {
    pub(crate) network: &'a Autoencoder,
    pub(crate) architecture: &'a Architecture,
    pub(crate) unit_embedding: bool,
    pub(crate) frozen: &'a Frozen,
    pub(crate) features: &'a Features,
    pub(crate) views: &'a Views<'a>,
    pub(crate) device: &'a Device,
}

impl Trainer<'_> {
    /// Each graph's run on a view of the first and of the last group, latents from the view itself; a prediction is that of
    /// the group's next view.
    pub(crate) fn canary(&self) -> Canary {
        let last = self.views.groups.len() - 1;
        let chosen = (0..VIEWS).map(|i| &self.views.groups[i * last / (VIEWS - 1)].views);
        let cases = chosen.flat_map(|views| self.cases(views[0], views[1]));
        Canary { tolerance: TOLERANCE, cases: cases.collect() }
    }

    fn cases(&self, view: usize, other: usize) -> Vec<CanaryCase> {
        let Self { network, architecture, device, .. } = *self;
        let layout = architecture.latent;
        let crop = self.views.set.views[view].crop.to_chw();
        let x = self.views.conditioning(architecture.convention, view, view, false);
        let conditioning = table(x.clone(), 1, device);
        let inputs = encoder_input(architecture, self.features.crop(&[view], device), &conditioning);
        let factor = network.encode(layout, inputs, &Turn::new(layout, &conditioning));
        let source = self.features.measurement(&[view], device);
        let measurement = numbers(source.clone());
        let mean = numbers(factor.mean.clone());
        let log_variance = numbers(for_each_number(layout, factor.log_variance.clone()));

        let case = |role, inputs: &[&Vec<f32>], outputs: &[&Vec<f32>]| CanaryCase {
            role,
            inputs: inputs.iter().map(|&input| input.clone()).collect(),
            outputs: outputs.iter().map(|&output| output.clone()).collect(),
        };
        let decoded = |x: &Vec<f32>, source: Option<Tensor<2>>| {
            let conditioning = table(x.clone(), 1, device);
            let turn = Turn::new(layout, &conditioning);
            let seen = decoder_input(architecture, &conditioning, source);
            let decoded = network.decode(architecture, factor.mean.clone(), seen, &turn);
            (numbers(decoded.measurement), self.pixels(&numbers(decoded.image)))
        };
        match architecture.kind() {
            Kind::ViewpointDependent => {
                let (predicted, image) = decoded(&x, None);
                let mut cases = vec![
                    case(Role::Measurement, &[&crop], &[&measurement]),
                    case(Role::Encoder, &[&crop, &x], &[&mean, &log_variance]),
                    case(Role::Decoder, &[&mean, &x], &[&predicted]),
                    case(Role::Image, &[&mean, &x], &[&image]),
                ];
                if roles(architecture).contains(&Role::DecoderJacobian) {
                    let [d_latent, d_conditioning, _] = self.jacobian(&mean, &x, None);
                    let outputs = [&predicted, &d_latent, &d_conditioning];
                    cases.push(case(Role::DecoderJacobian, &[&mean, &x], &outputs));
                }
                cases
            }
            Kind::ViewpointPredictive => {
                let change = self.views.conditioning(architecture.convention, view, other, true);
                let (predicted, image) = decoded(&change, Some(source));
                let inputs = [&mean, &measurement, &change];
                let mut cases = vec![
                    case(Role::Measurement, &[&crop], &[&measurement]),
                    case(Role::Encoder, &[&crop], &[&mean, &log_variance]),
                    case(Role::Predictor, &inputs, &[&predicted]),
                    case(Role::Image, &inputs, &[&image]),
                ];
                if roles(architecture).contains(&Role::PredictorJacobian) {
                    let [d_latent, d_change, d_source] = self.jacobian(&mean, &change, Some(&measurement));
                    let outputs = [&predicted, &d_latent, &d_source, &d_change];
                    cases.push(case(Role::PredictorJacobian, &inputs, &outputs));
                }
                cases
            }
            Kind::Embedding => {
                let embedding = if self.unit_embedding {
                    normalized(factor.mean)
                } else {
                    factor.mean / (factor.log_variance.clamp(LOG_VARIANCE.0, LOG_VARIANCE.1).exp() + 1.0)
                };
                vec![case(Role::Encoder, &[&crop], &[&numbers(embedding)])]
            }
        }
    }

    /// By latent, conditioning and source, row by row through the trainer's automatic derivatives.
    fn jacobian(&self, latent: &[f32], x: &[f32], source: Option<&[f32]>) -> [Vec<f32>; 3] {
        let layout = self.architecture.latent;
        let input = |row: &[f32]| {
            let data = TensorData::new(row.to_vec(), [1, row.len()]);
            Tensor::<2>::from_data(data, self.device).require_grad()
        };
        let (mut d_latent, mut d_conditioning, mut d_source) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..self.architecture.measurement {
            let (latent, conditioning) = (input(latent), input(x));
            let turn = Turn::new(layout, &conditioning);
            let source = source.map(input);
            let seen = decoder_input(self.architecture, &conditioning, source.clone());
            let decoded = self.network.decode(self.architecture, latent.clone(), seen, &turn);
            let gradients = decoded.measurement.narrow(1, row, 1).sum().backward();
            let of = |input: &Tensor<2>, width: usize| {
                input.grad(&gradients).map_or_else(|| vec![0.0; width], numbers)
            };
            d_latent.extend(of(&latent, layout.dimension()));
            d_conditioning.extend(of(&conditioning, x.len()));
            d_source.extend(source.iter().flat_map(|source| of(source, self.architecture.measurement)));
        }
        [d_latent, d_conditioning, d_source]
    }

    fn pixels(&self, coefficients: &[f32]) -> Vec<f32> {
        let layer = &self.frozen.components.layer;
        let mut pixels = layer.bias.clone();
        for (weights, coefficient) in layer.weight.chunks_exact(pixels.len()).zip(coefficients) {
            pixels.iter_mut().zip(weights).for_each(|(pixel, weight)| *pixel += coefficient * weight);
        }
        pixels.into_iter().map(|pixel| pixel.clamp(0.0, 1.0)).collect()
    }
}
