//! What stage 2 is trained on: crops passed once through the frozen trunk, and once through a fixed basis.

use crate::architecture::Architecture;
use crate::train::data::components::Components;
use crate::train::data::views::Views;
use crate::train::network::half::rounded_layer;
use crate::train::network::rows::{gather, numbers};
use crate::train::network::weights::Dense;
use crate::train::trunk::network::Trunk;
use burn::tensor::{Device, Tensor, TensorData};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Crops in a pass through the trunk.
const CHUNK: usize = 256;
/// Least share of the largest deviation that standardising divides by, so that features which hardly vary are not
/// blown up, rounding errors and all.
const LEAST_DEVIATION: f64 = 0.02;
/// Least share of the largest variance that whitening divides by.
const LEAST_VARIANCE: f64 = 1e-6;
/// Least weight of an image coefficient, beside 1 for the one that varies most.
const LEAST_WEIGHT: f32 = 0.05;

/// The frozen trunk, with what its outputs are standardised by.
pub(crate) struct Frozen {
    pub(crate) trunk: Trunk,
    /// Of each number of `t(z)`.
    pub(crate) mean: Vec<f32>,
    /// Reciprocal of the deviation of each number of `t(z)`.
    pub(crate) scale: Vec<f32>,
    /// From `t(z)` to the whitened `m(z)`.
    pub(crate) measurement: Dense,
    pub(crate) components: Components,
}

/// Of each view, row-major: features, whitened measurement, image coefficients.
pub(crate) struct Features {
    widths: [usize; 3],
    trunk: Vec<f32>,
    measurement: Vec<f32>,
    image: Vec<f32>,
    /// Weight of each image coefficient's likelihood: its deviation over the largest.
    pub(crate) image_weights: Vec<f32>,
}

impl Frozen {
    /// Freezes a trained trunk: standardises `t`, whitens `m` (IV-C) and fits the basis on training views.
    pub(crate) fn fit(
        trunk: Trunk,
        measurement: Dense,
        views: &Views,
        architecture: &Architecture,
        components: Components,
        device: &Device,
    ) -> Self {
        let features = passed(&trunk, views, device);
        let width = architecture.features;
        let (mean, scale) = moments(&features, width);
        let measurement = whitened(measurement, &features, width);
        Self { trunk, mean, scale, measurement, components }
    }

    /// What stage 2 sees of views.
    pub(crate) fn features(&self, views: &Views, device: &Device) -> Features {
        let mut trunk = passed(&self.trunk, views, device);
        let width = self.mean.len();
        let measurement = self.measure(&trunk);
        for row in trunk.chunks_exact_mut(width) {
            for ((value, mean), scale) in row.iter_mut().zip(&self.mean).zip(&self.scale) {
                *value = (*value - mean) * scale;
            }
        }
        let largest = self.components.deviation.iter().fold(f32::MIN_POSITIVE, |a, &b| a.max(b));
        Features {
            widths: [width, self.measurement.outputs(), self.components.deviation.len()],
            trunk,
            measurement,
            image: self.components.coefficients(views.set.views.iter().map(|view| &view.crop)),
            image_weights: self
                .components
                .deviation
                .iter()
                .map(|d| (d / largest).max(LEAST_WEIGHT))
                .collect(),
        }
    }

    /// `m(z)` of features `t(z)`, row by row.
    pub(crate) fn measure(&self, features: &[f32]) -> Vec<f32> {
        let Dense { weight, bias } = &self.measurement;
        let width = self.mean.len();
        let mut rows = Vec::with_capacity(features.len() / width * bias.len());
        for row in features.chunks_exact(width) {
            let mut m: Vec<f64> = bias.iter().map(|&b| f64::from(b)).collect();
            for (&t, weights) in row.iter().zip(weight.chunks_exact(bias.len())) {
                for (m, &w) in m.iter_mut().zip(weights) {
                    *m += f64::from(t) * f64::from(w);
                }
            }
            rows.extend(m.iter().map(|&m| m as f32));
        }
        rows
    }
}

impl Features {
    /// What the encoder sees of crops: standardised `t(z)`, which tells the viewpoint, then the image coefficients,
    /// which tell the instance; `[views, features + components]`.
    pub(crate) fn crop(&self, views: &[usize], device: &Device) -> Tensor<2> {
        Tensor::cat(vec![gather(&self.trunk, self.widths[0], views, device), self.image(views, device)], 1)
    }

    /// Whitened `m(z)`, `[views, measurement]`.
    pub(crate) fn measurement(&self, views: &[usize], device: &Device) -> Tensor<2> {
        gather(&self.measurement, self.widths[1], views, device)
    }

    /// Image coefficients of unit variance, `[views, components]`.
    pub(crate) fn image(&self, views: &[usize], device: &Device) -> Tensor<2> {
        gather(&self.image, self.widths[2], views, device)
    }
}

/// `t(z)` of all views, row-major.
fn passed(trunk: &Trunk, views: &Views, device: &Device) -> Vec<f32> {
    let convolutions = trunk.convolutions();
    let mut features = Vec::new();
    for start in (0..views.len()).step_by(CHUNK) {
        let chunk = start..(start + CHUNK).min(views.len());
        let count = chunk.len();
        let outputs = convolutions.pass(&views.crops(chunk)).outputs();
        let shape = [count, outputs.len() / count];
        let convolved = Tensor::<2>::from_data(TensorData::new(outputs, shape), device);
        features.extend(numbers(trunk.features(convolved)));
    }
    features
}

/// Mean and reciprocal standard deviation of each column; no deviation is below [`LEAST_DEVIATION`] of the largest.
fn moments(table: &[f32], width: usize) -> (Vec<f32>, Vec<f32>) {
    let rows = (table.len() / width) as f64;
    let mut sums = vec![[0f64; 2]; width];
    for row in table.chunks_exact(width) {
        for (sum, &value) in sums.iter_mut().zip(row) {
            let value = f64::from(value);
            *sum = [sum[0] + value, sum[1] + value * value];
        }
    }
    let mean: Vec<f64> = sums.iter().map(|sum| sum[0] / rows).collect();
    let variance = sums.iter().zip(&mean).map(|(sum, mean)| (sum[1] / rows - mean * mean).max(0.0));
    let deviation: Vec<f64> = variance.map(f64::sqrt).collect();
    let least = LEAST_DEVIATION * deviation.iter().fold(f64::MIN_POSITIVE, |a, &b| a.max(b));
    (
        mean.iter().map(|&mean| mean as f32).collect(),
        deviation.iter().map(|&deviation| deviation.max(least).recip() as f32).collect(),
    )
}

/// The measurement layer followed by a shift and rotation that give `m` zero mean and unit covariance.
fn whitened(layer: Dense, features: &[f32], width: usize) -> Dense {
    let outputs = layer.outputs();
    let weight = DMatrix::from_row_iterator(width, outputs, layer.weight.iter().map(|&w| f64::from(w)));
    let rows = (features.len() / width) as f64;
    let mut mean = DVector::zeros(width);
    let mut squares = DMatrix::zeros(width, width);
    for chunk in features.chunks(CHUNK * width) {
        let numbers = chunk.iter().map(|&number| f64::from(number));
        let columns = DMatrix::from_iterator(width, chunk.len() / width, numbers);
        mean += columns.column_sum();
        squares += &columns * columns.transpose();
    }
    mean /= rows;
    let covariance = squares / rows - &mean * mean.transpose();
    let eigen = SymmetricEigen::new(weight.transpose() * covariance * &weight);
    let floor = LEAST_VARIANCE * eigen.eigenvalues.max() + f64::MIN_POSITIVE;
    let scale = eigen.eigenvalues.map(|value| value.max(floor).sqrt().recip());
    let whitened = weight * eigen.eigenvectors * DMatrix::from_diagonal(&scale);
    let bias = -(whitened.transpose() * mean);
    rounded_layer(Dense {
        weight: whitened.transpose().iter().map(|&w| w as f32).collect(),
        bias: bias.iter().map(|&b| b as f32).collect(),
    })
}
