//! Likeness by an embedding: how near the mean numbers of tracklets lie, whatever the side that is seen.
//!
//! ```text
//! p(crops of t, crops of s, .. | one object)  =  [ integral N(u; 0, diag(spread)) N(y_t; u, I) N(y_s; u, I) .. du ]^a
//! ```
//!
//! A tracklet's mean counts as a single view: its views are from one side, and err alike.

use super::copies::less_copies;
use super::likeness::{Heading, Likeness};
use super::view::{measured, views};
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::Values;
use nalgebra::DVector;
use vantage_model::{AnswerError, Embedding};

/// How far an embedding is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedSettings {
    /// Most views of a tracklet that are read, spread over it.
    pub views: usize,
    /// Of what its numbers tell: `a`.
    pub exponent: f64,
    /// Share of objects that look like another one.
    pub copies: f64,
}

impl Default for EmbeddedSettings {
    /// Fitted on pairs of tracklets of validation objects, in `sparse_loop`: see `docs/association.md`.
    fn default() -> Self {
        Self { views: 8, exponent: 0.2, copies: 0.1 }
    }
}

/// Likeness by an embedding.
#[derive(Clone)]
pub struct Embedded<E> {
    embedding: E,
    settings: EmbeddedSettings,
}

/// Readings taken together: how many, the sum of their numbers, and what each is alone.
#[derive(Clone, Debug, Default)]
pub struct EmbeddedSum {
    count: usize,
    sum: Vec<f64>,
    alone: f64,
}

impl<E: Embedding> Embedded<E> {
    /// By this embedding.
    pub fn new(embedding: E, settings: EmbeddedSettings) -> Self {
        Self { embedding, settings }
    }

    /// `log` of the integral for `count` readings of this sum, but for what their squares alone tell.
    fn log_evidence<'s>(&self, sum: impl Iterator<Item = &'s f64>, count: usize) -> f64 {
        let of = |(sum, spread): (&f64, &f64)| {
            let precision = 1.0 + count as f64 * spread;
            0.5 * (spread * sum * sum / precision - libm::log(precision))
        };
        sum.zip(self.embedding.spread().iter()).map(of).sum()
    }
}

impl<E: Embedding> Likeness for Embedded<E> {
    /// The mean of the views' numbers; none where no crop is read.
    type Reading = Option<DVector<f64>>;
    type Sum = EmbeddedSum;

    fn read(
        &self,
        problem: &Problem<'_>,
        values: &Values,
        sightings: &[Sighting],
    ) -> Result<Self::Reading, AnswerError> {
        let views = views(problem, values, sightings, self.settings.views);
        let embedded = measured(views, |crop| self.embedding.embed(crop))?;
        let count = embedded.len() as f64;
        Ok(embedded
            .into_iter()
            .map(|(_, numbers)| numbers)
            .reduce(|sum, numbers| sum + numbers)
            .map(|sum| sum / count))
    }

    fn add(&self, sum: &mut EmbeddedSum, reading: &Self::Reading, _: Heading) {
        let Some(numbers) = reading else { return };
        sum.count += 1;
        sum.sum.resize(numbers.len(), 0.0);
        sum.sum.iter_mut().zip(numbers.iter()).for_each(|(sum, number)| *sum += number);
        sum.alone += self.log_evidence(numbers.iter(), 1);
    }

    fn log_ratio(&self, sum: &EmbeddedSum) -> f64 {
        if sum.count < 2 {
            return 0.0;
        }
        let together = self.log_evidence(sum.sum.iter(), sum.count);
        let ratio = self.settings.exponent * (together - sum.alone);
        less_copies(ratio, ratio, (sum.count, self.settings.copies))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{DMatrix, dvector};
    use vantage_dataset::Crop;

    struct Numbers(DVector<f64>);

    impl Embedding for Numbers {
        fn spread(&self) -> &DVector<f64> {
            &self.0
        }

        fn embed(&self, _: &Crop) -> Result<DVector<f64>, AnswerError> {
            Err(AnswerError::NonFinite { what: "what is not used" })
        }
    }

    /// `log` of a Gaussian's density.
    fn log_density(x: &DVector<f64>, covariance: DMatrix<f64>) -> f64 {
        let root = covariance.cholesky().unwrap();
        let constant = x.len() as f64 * libm::log(2.0 * std::f64::consts::PI);
        -0.5 * (x.dot(&root.solve(x)) + libm::log(root.determinant()) + constant)
    }

    #[test]
    fn three_readings_have_the_ratio_of_their_densities() {
        let settings = EmbeddedSettings { views: 8, exponent: 1.0, copies: 0.0 };
        let embedded = Embedded::new(Numbers(dvector![4.0, 0.5]), settings);
        let readings = [dvector![1.5, -0.2], dvector![2.5, 0.9], dvector![0.3, 0.1]].map(Some);
        let parts: Vec<_> = readings.iter().map(|reading| (reading, Heading::default())).collect();
        let expected: f64 = [4.0, 0.5]
            .iter()
            .enumerate()
            .map(|(k, spread)| {
                let x =
                    DVector::from_iterator(3, readings.iter().map(|reading| reading.as_ref().unwrap()[k]));
                let own = DMatrix::identity(3, 3);
                let shared = DMatrix::from_element(3, 3, *spread);
                let apart = DMatrix::identity(3, 3) * (1.0 + spread);
                log_density(&x, own + shared) - log_density(&x, apart)
            })
            .sum();
        assert_relative_eq!(embedded.log_ratio_of(&parts), expected, epsilon = 1e-12);
        assert_eq!(embedded.log_ratio_of(&parts[..1]), 0.0);
        assert_eq!(embedded.log_ratio_of(&[(&None, Heading::default()), parts[0]]), 0.0);
    }
}
