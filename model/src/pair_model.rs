//! The viewpoint-predictive model of Eq. 15: a second view, given the first one.

use crate::{AnswerError, MeasurementNoise, ObservationModel, ViewpointDerivative};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::Viewpoint;

/// `p(m(z') | z, e, Delta X)` of Eq. 15, beside `p(m(z) | e, x_rel)` of a view that no other is known of.
///
/// The change `Delta X` is told as the two viewpoints that it lies between.
pub trait PairModel: ObservationModel {
    /// The distribution of the second view's measurement about [`PairModel::predict_pair`]; that of single views unless told.
    fn pair_noise(&self) -> &MeasurementNoise {
        self.noise()
    }

    /// `h(e, m(z), x_rel, x_rel')`, `[M]`: the second view's measurement expected of latent `e` (`[D]`) and the first view.
    fn predict_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<DVector<f64>, AnswerError>;

    /// [`PairModel::predict_pair`] with its exact derivatives.
    fn linearize_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<PairLinearization, AnswerError>;
}

/// The view that another is predicted from.
#[derive(Clone, Copy, Debug)]
pub struct FirstView<'a> {
    /// `m(z)`, `[M]`.
    pub measurement: &'a DVector<f64>,
    /// `x_rel`.
    pub viewpoint: &'a Viewpoint,
}

/// A second view's prediction near a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PairLinearization {
    /// `h(e, m(z), x_rel, x_rel')`, `[M]`.
    pub mean: DVector<f64>,
    /// `d h / d e`, `[M x D]`.
    pub d_latent: DMatrix<f64>,
    /// `d h / d m(z)`, `[M x M]`.
    pub d_first_measurement: DMatrix<f64>,
    /// `d h / d x_rel`.
    pub d_first_viewpoint: ViewpointDerivative,
    /// `d h / d x_rel'`.
    pub d_second_viewpoint: ViewpointDerivative,
}

impl PairLinearization {
    /// Whether it has the shapes of M measured and D latent numbers and is finite throughout.
    pub fn is_valid(&self, measurement_dim: usize, latent_dim: usize) -> bool {
        let Self { mean, d_latent, d_first_measurement, d_first_viewpoint, d_second_viewpoint } = self;
        mean.len() == measurement_dim
            && d_latent.shape() == (measurement_dim, latent_dim)
            && d_first_measurement.shape() == (measurement_dim, measurement_dim)
            && mean.iter().chain(d_latent).chain(d_first_measurement).all(|x| x.is_finite())
            && [d_first_viewpoint, d_second_viewpoint].iter().all(|d| d.is_valid(measurement_dim))
    }
}
