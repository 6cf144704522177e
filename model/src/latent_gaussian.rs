//! Gaussians over a latent, and their product.

use nalgebra::DVector;

/// What one view, or several, say about a latent: a Gaussian of independent numbers.
///
/// An encoder's Gaussian is a *factor*, not yet a posterior: [`LatentGaussian::posterior`] multiplies such
/// factors with the prior.
#[derive(Clone, Debug, PartialEq)]
pub struct LatentGaussian {
    /// Mean, `[D]`.
    pub mean: DVector<f64>,
    /// Variances, `[D]`, positive.
    pub variance: DVector<f64>,
}

/// The product of the prior N(0, I) with the factors of views, in information form.
#[derive(Clone, Debug, PartialEq)]
pub struct Information {
    /// Sum of the precisions, `[D]`: 1 of the prior, and `1 / variance` of each view.
    pub precision: DVector<f64>,
    /// Sum of the means, each times its precision, `[D]`.
    pub weighted_mean: DVector<f64>,
}

impl Information {
    /// The product over `views`, of `dimension` numbers each.
    pub fn of<'a>(dimension: usize, views: impl IntoIterator<Item = &'a LatentGaussian>) -> Self {
        let mut precision = DVector::from_element(dimension, 1.0);
        let mut weighted_mean = DVector::zeros(dimension);
        for view in views {
            let information = view.variance.map(f64::recip);
            weighted_mean += view.mean.component_mul(&information);
            precision += information;
        }
        Self { precision, weighted_mean }
    }
}

impl LatentGaussian {
    /// The prior P(e) = N(0, I).
    pub fn prior(dimension: usize) -> Self {
        Self { mean: DVector::zeros(dimension), variance: DVector::from_element(dimension, 1.0) }
    }

    /// `q(e | z_1..z_n, x_1..x_n)`: the product of the views' factors and the prior `N(0, I)`.
    ///
    /// Without views this is the prior.
    pub fn posterior<'a>(dimension: usize, views: impl IntoIterator<Item = &'a LatentGaussian>) -> Self {
        let Information { precision, weighted_mean } = Information::of(dimension, views);
        Self { mean: weighted_mean.component_div(&precision), variance: precision.map(f64::recip) }
    }

    /// Keeps the first `dimension` numbers: the marginal over them.
    pub fn truncate(&mut self, dimension: usize) {
        self.mean = self.mean.rows(0, dimension.min(self.mean.len())).into_owned();
        self.variance = self.variance.rows(0, dimension.min(self.variance.len())).into_owned();
    }

    /// Whether it is a Gaussian over `dimension` numbers: finite means, finite positive variances.
    pub fn is_valid(&self, dimension: usize) -> bool {
        self.mean.len() == dimension
            && self.variance.len() == dimension
            && self.mean.iter().all(|m| m.is_finite())
            && self.variance.iter().all(|v| v.is_finite() && *v > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn views_add_information() {
        let view = LatentGaussian {
            mean: DVector::from_vec(vec![2.0, -1.0]),
            variance: DVector::from_vec(vec![0.5, 1.0]),
        };
        let product = LatentGaussian::posterior(2, [&view, &view]);
        assert_relative_eq!(product.variance, DVector::from_vec(vec![0.2, 1.0 / 3.0]), epsilon = 1e-12);
        assert_relative_eq!(product.mean, DVector::from_vec(vec![1.6, -2.0 / 3.0]), epsilon = 1e-12);
        assert_eq!(LatentGaussian::posterior(3, []), LatentGaussian::prior(3));
    }

    #[test]
    fn a_posterior_without_views_is_the_prior_and_views_narrow_it() {
        let view = LatentGaussian {
            mean: DVector::from_vec(vec![2.0, -1.0, 0.0]),
            variance: DVector::from_vec(vec![1.0, 0.5, 4.0]),
        };
        let one = LatentGaussian::posterior(3, [&view]);
        assert_relative_eq!(one.mean[0], 1.0, epsilon = 1e-12);
        assert_relative_eq!(one.variance[1], 1.0 / 3.0, epsilon = 1e-12);
        let two = LatentGaussian::posterior(3, &[view.clone(), view]);
        assert!(two.variance.iter().zip(one.variance.iter()).all(|(two, one)| two < one));
    }

    #[test]
    fn what_is_no_gaussian_is_told() {
        let of = |mean: f64, variance: f64| LatentGaussian {
            mean: DVector::from_element(2, mean),
            variance: DVector::from_element(2, variance),
        };
        assert!(of(0.0, 1.0).is_valid(2) && !of(0.0, 1.0).is_valid(3));
        for (mean, variance) in [(f64::NAN, 1.0), (0.0, 0.0), (0.0, -1.0), (0.0, f64::INFINITY)] {
            assert!(!of(mean, variance).is_valid(2), "{mean}, {variance}");
        }
    }
}
