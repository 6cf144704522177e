//! The viewpoint-dependent model: `p(z | e, x_rel)`.

use crate::difference::central_differences;
use crate::error::ModelError;
use crate::folder::{ModelFolder, factor, matrix, narrowed, widened};
use crate::latent::Latent;
use crate::role::Role;
use crate::viewing::Viewing;
use nalgebra::DVector;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, ViewpointDerivative,
};

/// `q(e | z, x_rel)` and `p(z | e, x_rel)` of Eq. 10-12, and the reduced measurement `m(z)` of IV-C: an
/// [`ObservationModel`], and its graphs by the numbers that these are given.
#[derive(Debug)]
pub struct ViewpointModel {
    pub(crate) folder: ModelFolder,
    noise: MeasurementNoise,
}

impl ViewpointModel {
    pub(crate) fn new(folder: ModelFolder) -> Self {
        Self { noise: folder.noise().law(), folder }
    }

    /// `q`, by the encoder's graph.
    pub(crate) fn factor(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        let x = narrowed(&viewpoint.conditioning());
        let [mean, log_variance] = self.folder.run(Role::Encoder, [&crop.to_chw(), &x])?;
        Ok(factor(&mean, &log_variance))
    }

    /// `m(e, x)`, `[d_m]`, by the decoder's graph, of a latent and a viewpoint's conditioning.
    pub fn decode(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError> {
        self.decode_from(latent.as_slice(), x)
    }

    /// [`ViewpointModel::decode`] with its derivatives, by the Jacobian's graph.
    ///
    /// A model without that graph ([`ViewpointModel::has`] [`Role::DecoderJacobian`]) pays with
    /// `2 (latent + CONDITIONING)` runs of its decoder, for central differences.
    pub fn decode_linear(
        &self,
        latent: &DVector<f64>,
        x: &[f64; CONDITIONING],
    ) -> Result<Linearization, ModelError> {
        if !self.has(Role::DecoderJacobian) {
            let e = latent.as_slice();
            return Ok(Linearization {
                mean: self.decode_from(e, x)?,
                d_latent: central_differences(e, |e| self.decode_from(e, x))?,
                d_viewpoint: ViewpointDerivative::new(central_differences(x, |x| self.decode_from(e, x))?),
            });
        }
        let inputs = [&narrowed(latent.as_slice())[..], &narrowed(x)];
        self.folder.read(Role::DecoderJacobian, inputs, |[m, d_latent, d_conditioning]| Linearization {
            mean: widened(m),
            d_latent: matrix(m.len(), d_latent),
            d_viewpoint: ViewpointDerivative::new(matrix(m.len(), d_conditioning)),
        })
    }

    /// The crop expected of a latent from a viewpoint; an error of a model without the graph for that.
    pub fn decode_image(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Crop, ModelError> {
        let [planes] = self.folder.run(Role::Image, [&narrowed(latent.as_slice()), &narrowed(x)])?;
        Ok(Crop::from_chw(&planes))
    }

    /// Whether the model has one of the graphs that it need not have.
    pub fn has(&self, role: Role) -> bool {
        self.folder.has(role)
    }

    fn decode_from(&self, latent: &[f64], x: &[f64]) -> Result<DVector<f64>, ModelError> {
        let [m] = self.folder.run(Role::Decoder, [&narrowed(latent), &narrowed(x)])?;
        Ok(widened(&m))
    }
}

impl ObservationModel for ViewpointModel {
    fn latent_dim(&self) -> usize {
        self.latent().dimension
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        let [m] = self.folder.run(Role::Measurement, [&crop.to_chw()])?;
        Ok(widened(&m))
    }

    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        Ok(self.factor(crop, viewpoint)?)
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(self.decode(latent, &viewpoint.conditioning())?)
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        Ok(self.decode_linear(latent, &viewpoint.conditioning())?)
    }
}

impl Viewing for ViewpointModel {
    fn latent(&self) -> Latent {
        self.folder.manifest.latent
    }

    fn reconstruct(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Option<Result<Crop, AnswerError>> {
        let predicted = || self.decode_image(latent, &viewpoint.conditioning()).map_err(ModelError::into);
        self.has(Role::Image).then(predicted)
    }
}
