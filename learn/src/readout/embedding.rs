//! What an embedding's numbers say of who is who: how far views of one object lie apart, and objects from each other.

use crate::Model;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::{Crop, ViewSet};
use vantage_model::{AnswerError, Embedding};

/// Of the covariance within objects, as a share of its mean variance: numbers of one length leave a direction nearly free.
const RIDGE: f64 = 1e-3;

/// What is fitted: `y = basis (numbers - center)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EmbeddingWeights {
    center: DVector<f64>,
    /// `[K, D]`: views of one object have the variances 1 in it, and none in common.
    basis: DMatrix<f64>,
    /// Variances of objects, `[K]`, all positive.
    spread: DVector<f64>,
}

impl EmbeddingWeights {
    /// The covariances of a model's numbers within and between the instances of a set; `Ok(None)` with too few views or instances.
    pub fn fit(model: &Model, set: &ViewSet) -> Result<Option<Self>, AnswerError> {
        let mut views = Vec::with_capacity(set.views.len());
        for view in &set.views {
            views.push((view.instance, DVector::from_vec(model.embed(&view.crop, None)?)));
        }
        Ok(Self::of(&views))
    }

    /// Likewise, of instances with their numbers.
    fn of(views: &[(usize, DVector<f64>)]) -> Option<Self> {
        let mut instances: BTreeMap<usize, Vec<&DVector<f64>>> = BTreeMap::new();
        views.iter().for_each(|(instance, numbers)| instances.entry(*instance).or_default().push(numbers));
        instances.retain(|_, numbers| numbers.len() > 1);
        let dimension = views.first()?.1.len();
        let mean = |numbers: &[&DVector<f64>]| -> DVector<f64> {
            let sum = numbers.iter().fold(DVector::zeros(dimension), |sum, &numbers| sum + numbers);
            sum / numbers.len() as f64
        };
        let means: Vec<DVector<f64>> = instances.values().map(|numbers| mean(numbers)).collect();
        let center = mean(&means.iter().collect::<Vec<_>>());
        let square = |off: DVector<f64>| &off * off.transpose();
        let (mut within, mut between) =
            (DMatrix::zeros(dimension, dimension), DMatrix::zeros(dimension, dimension));
        let (mut free, mut noise) = (0, 0.0);
        for (numbers, own) in instances.values().zip(&means) {
            numbers.iter().for_each(|&numbers| within += square(numbers - own));
            between += square(own - &center);
            free += numbers.len() - 1;
            noise += 1.0 / numbers.len() as f64;
        }
        if means.len() < 2 || free <= dimension {
            return None;
        }
        within /= free as f64;
        // A mean of few views has some of their spread.
        between = between / (means.len() - 1) as f64 - &within * (noise / means.len() as f64);
        within += DMatrix::identity(dimension, dimension) * (RIDGE * within.trace() / dimension as f64);
        let whiten = Cholesky::new(within)?.l().try_inverse()?;
        let SymmetricEigen { eigenvectors, eigenvalues } =
            SymmetricEigen::new(&whiten * between * whiten.transpose());
        let told: Vec<usize> = (0..dimension).filter(|&k| eigenvalues[k] > 0.0).collect();
        let basis = eigenvectors.select_columns(&told).transpose() * whiten;
        Some(Self { center, basis, spread: eigenvalues.select_rows(&told) })
    }
}

/// A model's numbers in that basis.
#[derive(Clone, Copy)]
pub struct EmbeddingReadout<'m> {
    model: &'m Model,
    weights: &'m EmbeddingWeights,
}

impl<'m> EmbeddingReadout<'m> {
    /// By `weights` fitted to what `model` says.
    pub fn new(model: &'m Model, weights: &'m EmbeddingWeights) -> Self {
        Self { model, weights }
    }
}

impl Embedding for EmbeddingReadout<'_> {
    fn spread(&self) -> &DVector<f64> {
        &self.weights.spread
    }

    fn embed(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        let numbers = DVector::from_vec(self.model.embed(crop, None)?);
        Ok(&self.weights.basis * (numbers - &self.weights.center))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    #[test]
    fn the_basis_makes_both_covariances_diagonal_and_finds_the_variances() {
        let mut stream = Seed(7).stream("embedding", 0);
        let mixed = DMatrix::from_row_slice(3, 3, &[1.0, 0.4, 0.0, -0.3, 2.0, 0.5, 0.2, 0.0, 0.7]);
        let shift = DVector::from_vec(vec![5.0, -1.0, 2.0]);
        // In the first number objects differ by a deviation of 3, in the second by one of 1, in the third not at all.
        let spread = [3.0, 1.0, 0.0];
        let mut views = Vec::new();
        for instance in 0..3000 {
            let own = DVector::from_fn(3, |k, _| spread[k] * stream.normal());
            for _ in 0..4 {
                let y = DVector::from_fn(3, |k, _| own[k] + stream.normal());
                views.push((instance, &mixed * y + &shift));
            }
        }
        let weights = EmbeddingWeights::of(&views).unwrap();
        let mut found: Vec<f64> = weights.spread.iter().copied().collect();
        found.sort_by(|a, b| b.total_cmp(a));
        assert_relative_eq!(found[0], 9.0, max_relative = 0.1);
        assert_relative_eq!(found[1], 1.0, max_relative = 0.1);
        assert!(found.get(2).is_none_or(|least| *least < 0.05), "{found:?}");
        assert!(EmbeddingWeights::of(&views[..4]).is_none());
        assert!(EmbeddingWeights::of(&[]).is_none());
    }
}
