//! What the trained networks say of views, as the calibration and the sheet ask it.

use crate::architecture::Architecture;
use crate::train::autoencoder::features::Features;
use crate::train::autoencoder::network::{Autoencoder, decoder_input, encoder_input};
use crate::train::data::views::Views;
use crate::train::network::rows::{numbers, table};
use crate::train::network::turn::{Turn, for_each_number};
use burn::tensor::{Device, Tensor, TensorData};
use nalgebra::DVector;
use vantage_model::LatentGaussian;

/// A trained autoencoder over the features of some views.
pub(crate) struct Predictions<'a> {
    pub(crate) network: &'a Autoencoder,
    pub(crate) architecture: &'a Architecture,
    pub(crate) views: &'a Views<'a>,
    pub(crate) features: &'a Features,
    pub(crate) device: &'a Device,
}

impl Predictions<'_> {
    /// The posterior of a latent in the frame of view `from`, given views of its group.
    pub(crate) fn posterior(&self, from: usize, views: &[usize]) -> LatentGaussian {
        let layout = self.architecture.latent;
        let conditioning = self.conditioning(from, views);
        let turn = Turn::new(layout, &conditioning);
        let crops = self.features.crop(views, self.device);
        let factor =
            self.network.encode(layout, encoder_input(self.architecture, crops, &conditioning), &turn);
        let (mean, variance) =
            (numbers(factor.mean), numbers(for_each_number(layout, factor.log_variance).exp()));
        let vector = |row: &[f32]| DVector::from_iterator(row.len(), row.iter().map(|&v| f64::from(v)));
        let dimension = layout.dimension();
        let rows = mean.chunks_exact(dimension).zip(variance.chunks_exact(dimension));
        let factors: Vec<_> =
            rows.map(|(m, v)| LatentGaussian { mean: vector(m), variance: vector(v) }).collect();
        LatentGaussian::posterior(dimension, &factors)
    }

    /// Measurement `[views, measurement]` and image coefficients `[views, components]` expected of a latent in the frame of
    /// view `from`, by itself, from the viewpoints of `views`.
    pub(crate) fn decode(&self, latent: &DVector<f64>, from: usize, views: &[usize]) -> (Vec<f32>, Vec<f32>) {
        let layout = self.architecture.latent;
        let row: Vec<f32> = latent.iter().map(|&number| number as f32).collect();
        let latents = Tensor::<2>::from_data(TensorData::new(row, [1, layout.dimension()]), self.device);
        let latents = latents.repeat_dim(0, views.len());
        let conditioning = self.conditioning(from, views);
        let turn = Turn::new(layout, &conditioning);
        let nothing = vec![0.0; views.len() * self.architecture.measurement];
        let seen =
            decoder_input(self.architecture, &conditioning, Some(table(nothing, views.len(), self.device)));
        let decoded = self.network.decode(self.architecture, latents, seen, &turn);
        (numbers(decoded.measurement), numbers(decoded.image))
    }

    fn conditioning(&self, from: usize, views: &[usize]) -> Tensor<2> {
        let of = |&view: &usize| self.views.conditioning(self.architecture.convention, from, view, false);
        table(views.iter().flat_map(of).collect(), views.len(), self.device)
    }
}
