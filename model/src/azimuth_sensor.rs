//! A sensor that reads off one crop from which azimuth it was taken.

use crate::AnswerError;
use vantage_dataset::Crop;

/// What one crop says of the azimuth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AzimuthReading {
    /// Azimuth of the camera about the object's z axis, radians.
    pub azimuth: f64,
    /// Scale of its error, radians: the standard deviation where the degrees of freedom are infinite.
    pub sigma: f64,
}

/// `p(azimuth | z)` of objects whose frames it knows, with neither latent nor class.
pub trait AzimuthSensor: Send + Sync {
    /// The reading of a crop.
    fn read(&self, crop: &Crop) -> Result<AzimuthReading, AnswerError>;

    /// `nu` of the Student t of the error over its sigma, infinity for a Gaussian.
    fn degrees_of_freedom(&self) -> f64;
}
