//! The observation model `p(z | e, x_rel)` with its encoder `q(e | z, x_rel)` of III-A.

use crate::{AnswerError, LatentGaussian, Linearization, MeasurementNoise};
use nalgebra::DVector;
use vantage_dataset::{Crop, Viewpoint};

/// `p(m(z) | e, x_rel)` of Eq. 10 and `q(e | z, x_rel)` of Eq. 12, M measured numbers and D latent ones.
pub trait ObservationModel: Send + Sync {
    /// D, the length of a latent `e`.
    fn latent_dim(&self) -> usize;

    /// M, the length of a reduced measurement `m(z)`.
    fn measurement_dim(&self) -> usize {
        self.noise().dimension()
    }

    /// The distribution of `m(z) - h(e, x_rel)`.
    fn noise(&self) -> &MeasurementNoise;

    /// `m(z)`, `[M]`: the reduced measurement of a crop.
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError>;

    /// `q(e | z, x_rel)`: the factor of one view on the latent, `[D]`.
    ///
    /// The orientation search asks for one crop under every yaw of its grid: what depends on the crop alone is
    /// worth keeping between calls.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError>;

    /// `h(e, x_rel)`, `[M]`: the measurement expected of latent `e` (`[D]`) from a viewpoint.
    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError>;

    /// [`ObservationModel::predict`] with its exact derivatives.
    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError>;
}
