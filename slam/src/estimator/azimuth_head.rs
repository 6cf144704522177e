//! P(X, O | U, Z^g, azimuths): geometric, with an azimuth read off each crop as a plain sensor, without latent or class.

use super::Estimator;
use super::hypotheses::{Hypotheses, Joined, Reading};
use crate::estimate::Estimate;
use crate::factor::AzimuthFactor;
use crate::graph::Graph;
use crate::input::EstimateError;
use crate::semantics::unless_non_finite;
use crate::settings::{SemanticSettings, Settings};
use nalgebra::DVector;
use vantage_dataset::{Crop, Observations};
use vantage_model::{AnswerError, AzimuthReading, AzimuthSensor};

/// The geometric estimator's factors and a [sensor](AzimuthSensor) of azimuths.
#[derive(Clone, Debug)]
pub struct AzimuthHead<S> {
    hypotheses: Hypotheses,
    sensor: S,
}

impl<S: AzimuthSensor> AzimuthHead<S> {
    /// An estimator that reads crops by `sensor`.
    pub fn new(settings: &Settings, sensor: S) -> Self {
        Self { hypotheses: Hypotheses::new(settings), sensor }
    }
}

impl<S: AzimuthSensor> Estimator for AzimuthHead<S> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        let reading = Azimuths { sensor: &self.sensor, settings: self.hypotheses.semantics };
        Ok(self.hypotheses.estimate(&reading, observations)?.0)
    }
}

/// One hypothesis: the object's frame is that of the sensor.
struct Azimuths<'s> {
    sensor: &'s dyn AzimuthSensor,
    settings: SemanticSettings,
}

impl Reading for Azimuths<'_> {
    fn hypotheses(&self) -> usize {
        1
    }

    /// Azimuth and sigma.
    fn measure(&self, crop: &Crop) -> Result<Option<DVector<f64>>, AnswerError> {
        let read = unless_non_finite(self.sensor.read(crop))?;
        let finite =
            |read: &AzimuthReading| read.azimuth.is_finite() && read.sigma.is_finite() && read.sigma > 0.0;
        Ok(read.filter(finite).map(|read| DVector::from_vec(vec![read.azimuth, read.sigma])))
    }

    fn add<'m>(&'m self, graph: &mut Graph<'m>, _: usize, of: &Joined<'_>) {
        let measured = &of.view.measurement;
        let reading = AzimuthReading { azimuth: measured[0], sigma: measured[1] * self.settings.noise_scale };
        let (mount, scale) = (of.observations.robot_from_camera, self.settings.information_scale);
        let nu = self.sensor.degrees_of_freedom();
        graph.push(AzimuthFactor::new(of.keys, reading, mount, nu, scale));
    }

    fn constant(&self, _: usize) -> f64 {
        0.0
    }
}
