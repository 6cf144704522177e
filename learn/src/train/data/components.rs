//! A fixed basis of crops: their principal components, which the image head weighs.

use crate::train::network::half::rounded;
use crate::train::network::weights::Dense;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use vantage_dataset::crop::CROP_BYTES;
use vantage_dataset::{Crop, Seed, ViewSet};

/// Crops the basis is fitted to, at most.
const SAMPLE: usize = 4096;
/// Directions tried beyond those kept, and rounds of power iteration (Halko, Martinsson and Tropp 2011).
const SPARE: usize = 16;
const ROUNDS: usize = 3;
/// Least share of the largest deviation that a coefficient is divided by, so that directions along which crops hardly
/// vary are not blown up, rounding errors and all.
const LEAST_DEVIATION: f32 = 0.01;
/// Crops in a product with the basis.
const CHUNK: usize = 512;

/// Mean crop and leading directions of variation; pixels in `[0, 1]`, `[3, 32, 32]`.
pub(crate) struct Components {
    /// From pixels to coefficients of unit variance.
    pub(crate) projection: Dense,
    /// From coefficients to pixels.
    pub(crate) layer: Dense,
    /// Standard deviation of the crops along each direction.
    pub(crate) deviation: Vec<f32>,
}

impl Components {
    /// Principal components by randomised subspace iteration.
    pub(crate) fn fit(set: &ViewSet, components: usize, seed: Seed) -> Self {
        let mut stream = seed.stream("components", 0);
        let mut order: Vec<usize> = (0..set.views.len()).collect();
        stream.shuffle(&mut order);
        order.truncate(SAMPLE);
        let mut pixels = matrix(order.iter().map(|&view| &set.views[view].crop));
        let mean = pixels.column_mean();
        pixels.column_iter_mut().for_each(|mut crop| crop -= &mean);
        let count = pixels.ncols() as f32;

        let crops = pixels.transpose();
        let mut basis = DMatrix::from_fn(CROP_BYTES, components + SPARE, |_, _| stream.normal() as f32);
        for _ in 0..=ROUNDS {
            basis = (&pixels * (&crops * basis)).qr().q();
        }
        let projected = basis.transpose() * &pixels;
        let eigen = SymmetricEigen::new(&projected * projected.transpose() / count);
        let mut ranked: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        ranked.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        ranked.truncate(components);
        let largest = eigen.eigenvalues.max().max(f32::MIN_POSITIVE);
        let least = LEAST_DEVIATION * largest.sqrt();
        let deviation = |&rank: &usize| eigen.eigenvalues[rank].max(0.0).sqrt().max(least);
        let deviation = DVector::from_iterator(components, ranked.iter().map(deviation));
        let directions = basis * eigen.eigenvectors.select_columns(&ranked);
        let inverse = DMatrix::from_diagonal(&deviation.map(f32::recip));
        let onto = &directions * inverse;
        let onto = DMatrix::from_column_slice(CROP_BYTES, components, &rounded(onto.as_slice()));
        let along = directions * DMatrix::from_diagonal(&deviation);
        Self {
            projection: Dense {
                bias: (onto.transpose() * -&mean).as_slice().to_vec(),
                weight: onto.transpose().as_slice().to_vec(),
            },
            layer: Dense { weight: rounded(along.as_slice()), bias: mean.as_slice().to_vec() },
            deviation: deviation.as_slice().to_vec(),
        }
    }

    /// Coefficients of crops, of unit variance, `[views, components]`, row-major.
    pub(crate) fn coefficients<'a>(&self, crops: impl Iterator<Item = &'a Crop>) -> Vec<f32> {
        let crops: Vec<&Crop> = crops.collect();
        let mut rows = Vec::with_capacity(crops.len() * self.deviation.len());
        let Dense { weight, bias } = &self.projection;
        let onto = DMatrix::from_column_slice(bias.len(), CROP_BYTES, weight);
        for chunk in crops.chunks(CHUNK) {
            let coefficients = &onto * matrix(chunk.iter().copied());
            for crop in coefficients.column_iter() {
                rows.extend(crop.iter().zip(bias).map(|(value, bias)| value + bias));
            }
        }
        rows
    }
}

/// Crops as the columns of a matrix, `[3072, crops]`.
fn matrix<'a>(crops: impl ExactSizeIterator<Item = &'a Crop>) -> DMatrix<f32> {
    let count = crops.len();
    DMatrix::from_iterator(CROP_BYTES, count, crops.flat_map(Crop::to_chw))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::synthetic;

    #[test]
    fn coefficients_have_unit_variance_and_rebuild_the_crops() {
        let set = synthetic::views(vantage_dataset::Split::Train, 6, 20, 1);
        let components = Components::fit(&set, 24, Seed(1));
        let rows = components.coefficients(set.views.iter().map(|view| &view.crop));
        let layer = &components.layer;
        assert_eq!((layer.inputs(), layer.outputs()), (24, CROP_BYTES));
        for column in [0, 5] {
            let mean = rows.iter().skip(column).step_by(24).sum::<f32>() / 120.0;
            let square = rows.iter().skip(column).step_by(24).map(|c| c * c).sum::<f32>() / 120.0;
            assert!(mean.abs() < 1e-3 && (square - 1.0).abs() < 1e-2, "{mean} {square}");
        }
        let (mut error, mut total) = (0.0, 0.0);
        for (view, row) in set.views.iter().zip(rows.chunks_exact(24)) {
            for (pixel, value) in view.crop.to_chw().iter().enumerate() {
                let rebuilt: f32 = layer.bias[pixel]
                    + row
                        .iter()
                        .enumerate()
                        .map(|(i, c)| c * layer.weight[i * CROP_BYTES + pixel])
                        .sum::<f32>();
                error += (rebuilt - value).powi(2);
                total += (layer.bias[pixel] - value).powi(2);
            }
        }
        assert!(error < 0.2 * total, "{error} of {total}");
    }
}
