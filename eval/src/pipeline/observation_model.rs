//! The seam between `learn` and `slam`: a trained model, run by tract, as the estimator's observation model.

use nalgebra::DVector;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};
use vantage_learn::{Model, Viewing};
use vantage_slam::{LatentGaussian, Linearization, MeasurementNoise, ModelError, ObservationModel};

/// A model folder as p(z | e, x_rel) of Eq. 10: a viewpoint-dependent model, or a viewpoint-predictive one without a first view.
pub struct TractModel {
    model: Model,
    noise: MeasurementNoise,
}

impl TractModel {
    /// Wraps a loaded model; `None` of one that is not of looks from viewpoints ([`Model::viewing`]).
    pub fn new(model: Model) -> Option<Result<Self, ModelError>> {
        let residual = model.viewing()?.noise().clone();
        let noise = MeasurementNoise::new(residual.sqrt_information(), residual.degrees_of_freedom, 1.0);
        Some(noise.map(|noise| Self { model, noise }))
    }

    /// The model itself.
    pub fn inner(&self) -> &Model {
        &self.model
    }

    /// The model as one of looks from viewpoints.
    pub fn viewing(&self) -> Box<dyn Viewing + '_> {
        self.model.viewing().expect("new made sure of it")
    }
}

/// An answer that is not finite costs a detection, anything else the run.
fn failed(error: vantage_learn::ModelError) -> ModelError {
    use vantage_learn::{GraphError, ModelError as Learned};
    match error {
        Learned::Run { source: GraphError::NonFiniteOutput { .. }, .. } => {
            ModelError::NonFinite { what: "output" }
        }
        Learned::Run { source: GraphError::InputRange { .. }, .. } => ModelError::NonFinite { what: "input" },
        error => ModelError::Runtime { message: error.to_string() },
    }
}

impl ObservationModel for TractModel {
    fn latent_dim(&self) -> usize {
        self.model.manifest().latent.dimension
    }

    fn measurement_dim(&self) -> usize {
        self.noise.sqrt_information().nrows()
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        self.viewing().measure(crop).map_err(failed)
    }

    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        let view = self.viewing().encode_view(crop, viewpoint).map_err(failed)?;
        Ok(LatentGaussian { mean: view.mean, variance: view.variance })
    }

    fn predict(
        &self,
        latent: &DVector<f64>,
        conditioning: &[f64; CONDITIONING],
    ) -> Result<DVector<f64>, ModelError> {
        self.viewing().predict(latent, conditioning).map_err(failed)
    }

    fn linearize(
        &self,
        latent: &DVector<f64>,
        conditioning: &[f64; CONDITIONING],
    ) -> Result<Linearization, ModelError> {
        let at = self.viewing().linearize(latent, conditioning).map_err(failed)?;
        Ok(Linearization { mean: at.measurement, d_latent: at.d_latent, d_conditioning: at.d_conditioning })
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }
}
