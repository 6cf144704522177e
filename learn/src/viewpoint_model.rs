//! The viewpoint-dependent model: `p(z | e, x_rel)`.

use crate::difference::central_differences;
use crate::error::ModelError;
use crate::folder::{ModelFolder, factor, matrix, narrowed, widened};
use crate::latent::{Latent, LatentGaussian};
use crate::manifest::Manifest;
use crate::model::load_kind;
use crate::residual::ResidualNoise;
use crate::role::{Kind, Role};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use std::path::Path;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, InstanceId, Viewpoint};

/// `q(e | z, x_rel)` and `p(z | e, x_rel)` of Eq. 10-12, and the reduced measurement `m(z)` of IV-C.
pub struct ViewpointModel(pub(crate) ModelFolder);

/// A predicted measurement and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// `m(e, x)`, `[d_m]`.
    pub measurement: DVector<f64>,
    /// `d m / d e`, `[d_m, latent]`.
    pub d_latent: DMatrix<f64>,
    /// `d m / d x`, `[d_m, CONDITIONING]`, by the conditioning's numbers as if they were independent;
    /// multiply by [`Conditioning::jacobian`](vantage_dataset::viewpoint::Conditioning::jacobian).
    pub d_conditioning: DMatrix<f64>,
}

impl ViewpointModel {
    /// Loads a folder as [`Model::load`](crate::Model::load) does, and refuses other kinds of model.
    pub fn load(folder: &Path) -> Result<Self, ModelError> {
        load_kind(folder, Kind::ViewpointDependent).map(Self)
    }

    /// `m(z)`, `[d_m]`.
    pub fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        let [m] = self.0.run(Role::Measurement, [&crop.to_chw()])?;
        Ok(widened(&m))
    }

    /// The factor `q` of one view on the latent, to be combined by [`LatentGaussian::posterior`].
    pub fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        let x = narrowed(&viewpoint.conditioning());
        let [mean, log_variance] = self.0.run(Role::Encoder, [&crop.to_chw(), &x])?;
        Ok(factor(&mean, &log_variance))
    }

    /// `m(e, x)`, `[d_m]`, of a latent and a viewpoint's conditioning.
    pub fn predict(
        &self,
        latent: &DVector<f64>,
        x: &[f64; CONDITIONING],
    ) -> Result<DVector<f64>, ModelError> {
        self.predict_from(latent.as_slice(), x)
    }

    /// [`ViewpointModel::predict`] with its derivatives.
    ///
    /// A model without the graph for that ([`ViewpointModel::has`] [`Role::DecoderJacobian`]) pays with
    /// `2 (latent + CONDITIONING)` runs of its decoder, for central differences.
    pub fn linearize(
        &self,
        latent: &DVector<f64>,
        x: &[f64; CONDITIONING],
    ) -> Result<Linearization, ModelError> {
        if !self.has(Role::DecoderJacobian) {
            let e = latent.as_slice();
            return Ok(Linearization {
                measurement: self.predict_from(e, x)?,
                d_latent: central_differences(e, |e| self.predict_from(e, x))?,
                d_conditioning: central_differences(x, |x| self.predict_from(e, x))?,
            });
        }
        let inputs = [&narrowed(latent.as_slice())[..], &narrowed(x)];
        self.0.read(Role::DecoderJacobian, inputs, |[m, d_latent, d_conditioning]| Linearization {
            measurement: widened(m),
            d_latent: matrix(m.len(), d_latent),
            d_conditioning: matrix(m.len(), d_conditioning),
        })
    }

    /// The crop expected of a latent from a viewpoint; an error of a model without the graph for that.
    pub fn reconstruct(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Crop, ModelError> {
        let [planes] = self.0.run(Role::Image, [&narrowed(latent.as_slice()), &narrowed(x)])?;
        Ok(Crop::from_chw(&planes))
    }

    /// Whether the model has one of the graphs that it need not have.
    pub fn has(&self, role: Role) -> bool {
        self.0.has(role)
    }

    /// Noise of `m(z) - m(e, x)`.
    pub fn noise(&self) -> &ResidualNoise {
        self.0.manifest.residual.as_ref().expect("a checked manifest of this kind has it")
    }

    /// The latent.
    pub fn latent(&self) -> Latent {
        self.0.manifest.latent
    }

    /// Numbers in the reduced measurement.
    pub fn measurement_dim(&self) -> usize {
        self.0.manifest.sizes().measurement
    }

    /// BLAKE3 of the manifest, which holds the hashes of all other files: the model's identity.
    pub fn hash(&self) -> &str {
        &self.0.hash
    }

    /// Where the model came from, and what it holds.
    pub fn manifest(&self) -> &Manifest {
        &self.0.manifest
    }

    /// The instances that it was trained or calibrated on, none of which may be scored.
    pub fn training_instances(&self) -> &BTreeSet<InstanceId> {
        &self.0.training_instances
    }

    fn predict_from(&self, latent: &[f64], x: &[f64]) -> Result<DVector<f64>, ModelError> {
        let [m] = self.0.run(Role::Decoder, [&narrowed(latent), &narrowed(x)])?;
        Ok(widened(&m))
    }
}

impl std::fmt::Debug for ViewpointModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ViewpointModel({})", self.0.hash)
    }
}
