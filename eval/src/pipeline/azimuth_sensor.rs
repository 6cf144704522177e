//! An ideal sensor of the azimuth from which an object is seen: what a model could at best be worth.

use super::true_views::true_viewpoint;
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Observations, Seed, Truth, Viewpoint};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, ViewpointDerivative,
};

/// Cosine and sine of the true azimuth with independent Gaussian noise of known size; a latent of one number that says nothing.
///
/// The readings are made of the truth before any estimator runs. An estimator sees them alone.
pub struct AzimuthSensor {
    noise: MeasurementNoise,
    by_crop: HashMap<Vec<u8>, DVector<f64>>,
}

impl AzimuthSensor {
    /// Reads every detection of an object, with noise of standard deviation `sigma`, radians.
    pub fn new(observations: &Observations, truth: &Truth, sigma: f64) -> Self {
        let world = truth.objects.first().map_or(0, |object| object.instance.0);
        let mut stream = Seed(world).stream("azimuth sensor", 0);
        let mut by_crop = HashMap::new();
        for (number, detection) in observations.detections.iter().enumerate() {
            // What the detector sees where there is nothing has no azimuth.
            if let Some((_, viewpoint)) = true_viewpoint(observations, truth, number) {
                let azimuth = viewpoint.azimuth() + sigma * stream.normal();
                let (sin, cos) = libm::sincos(azimuth);
                by_crop.insert(detection.masked_crop.0.to_vec(), DVector::from_vec(vec![cos, sin]));
            }
        }
        let information = DMatrix::identity(2, 2) / sigma;
        let noise = MeasurementNoise::new(information, f64::INFINITY).expect("sigma is positive");
        Self { noise, by_crop }
    }
}

impl ObservationModel for AzimuthSensor {
    fn latent_dim(&self) -> usize {
        1
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.by_crop.get(&crop.0[..]).cloned().ok_or(AnswerError::NonFinite { what: "azimuth" })
    }

    fn encode(&self, _: &Crop, _: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        Ok(LatentGaussian::prior(1))
    }

    fn predict(&self, _: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(DVector::from_column_slice(&viewpoint.conditioning()[..2]))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        Ok(Linearization {
            mean: self.predict(latent, viewpoint)?,
            d_latent: DMatrix::zeros(2, 1),
            d_viewpoint: ViewpointDerivative::new(DMatrix::identity(2, CONDITIONING)),
        })
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }
}
