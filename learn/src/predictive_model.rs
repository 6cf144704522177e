//! The viewpoint-predictive model: `p(z' | z, e, Delta X)`.

use crate::difference::central_differences;
use crate::error::ModelError;
use crate::folder::{ModelFolder, factor, matrix, narrowed, widened};
use crate::latent::Latent;
use crate::residual::ResidualNoise;
use crate::role::{Convention, Role};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::Crop;
use vantage_model::LatentGaussian;

/// `q(e | z)` and `p(z' | z, e, Delta X)` of Eq. 15-20, reduced to measurements as in IV-C.
#[derive(Debug)]
pub struct PredictiveModel(pub(crate) ModelFolder);

/// A predicted measurement of another view and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictiveLinearization {
    /// `m'(e, m, change)`, `[d_m]`.
    pub measurement: DVector<f64>,
    /// `d m' / d e`, `[d_m, latent]`.
    pub d_latent: DMatrix<f64>,
    /// `d m' / d m`, `[d_m, d_m]`.
    pub d_measurement: DMatrix<f64>,
    /// `d m' / d change`, `[d_m, change]`, by the change's numbers as if they were independent.
    pub d_change: DMatrix<f64>,
}

impl PredictiveModel {
    /// `m(z)`, `[d_m]`.
    pub fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        let [m] = self.0.run(Role::Measurement, [&crop.to_chw()])?;
        Ok(widened(&m))
    }

    /// The factor `q` of one view on the latent, to be combined by [`LatentGaussian::posterior`].
    pub fn encode(&self, crop: &Crop) -> Result<LatentGaussian, ModelError> {
        let [mean, log_variance] = self.0.run(Role::Encoder, [&crop.to_chw()])?;
        Ok(factor(&mean, &log_variance))
    }

    /// The other view's measurement, `[d_m]`, from a latent, the first view's measurement and the change of viewpoint
    /// in the numbers of [`PredictiveModel::convention`].
    pub fn predict(
        &self,
        latent: &DVector<f64>,
        measurement: &DVector<f64>,
        change: &[f64],
    ) -> Result<DVector<f64>, ModelError> {
        self.predict_from(latent.as_slice(), measurement.as_slice(), change)
    }

    /// [`PredictiveModel::predict`] with its derivatives; by central differences where the model has no graph for that
    /// ([`PredictiveModel::has`] [`Role::PredictorJacobian`]).
    pub fn linearize(
        &self,
        latent: &DVector<f64>,
        measurement: &DVector<f64>,
        change: &[f64],
    ) -> Result<PredictiveLinearization, ModelError> {
        let (e, m) = (latent.as_slice(), measurement.as_slice());
        if !self.has(Role::PredictorJacobian) {
            return Ok(PredictiveLinearization {
                measurement: self.predict_from(e, m, change)?,
                d_latent: central_differences(e, |e| self.predict_from(e, m, change))?,
                d_measurement: central_differences(m, |m| self.predict_from(e, m, change))?,
                d_change: central_differences(change, |change| self.predict_from(e, m, change))?,
            });
        }
        let inputs = [&narrowed(e)[..], &narrowed(m), &narrowed(change)];
        let read = |[other, d_latent, d_measurement, d_change]: [&[f32]; 4]| PredictiveLinearization {
            measurement: widened(other),
            d_latent: matrix(other.len(), d_latent),
            d_measurement: matrix(other.len(), d_measurement),
            d_change: matrix(other.len(), d_change),
        };
        self.0.read(Role::PredictorJacobian, inputs, read)
    }

    /// The other view's crop; an error of a model without the graph for that.
    pub fn reconstruct(
        &self,
        latent: &DVector<f64>,
        measurement: &DVector<f64>,
        change: &[f64],
    ) -> Result<Crop, ModelError> {
        let (e, m) = (narrowed(latent.as_slice()), narrowed(measurement.as_slice()));
        let [planes] = self.0.run(Role::Image, [&e, &m, &narrowed(change)])?;
        Ok(Crop::from_chw(&planes))
    }

    /// Whether the model has one of the graphs that it need not have.
    pub fn has(&self, role: Role) -> bool {
        self.0.has(role)
    }

    /// What the numbers of a change of viewpoint are.
    pub fn convention(&self) -> Convention {
        self.0.manifest.conditioning.expect("a checked manifest of this kind has it")
    }

    /// Noise of `m(z') - m'(e, m(z), change)`.
    pub fn noise(&self) -> &ResidualNoise {
        self.0.noise()
    }

    /// The latent.
    pub fn latent(&self) -> Latent {
        self.0.manifest.latent
    }

    /// Numbers in the reduced measurement.
    pub fn measurement_dim(&self) -> usize {
        self.0.manifest.sizes().measurement
    }

    fn predict_from(
        &self,
        latent: &[f64],
        measurement: &[f64],
        change: &[f64],
    ) -> Result<DVector<f64>, ModelError> {
        let inputs = [&narrowed(latent)[..], &narrowed(measurement), &narrowed(change)];
        let [other] = self.0.run(Role::Predictor, inputs)?;
        Ok(widened(&other))
    }
}
