//! What crops tell of who is who.

use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::Values;
use vantage_model::AnswerError;

/// Whether crops are of one object.
pub trait Likeness: Sync {
    /// What is read of one tracklet, whatever it is of.
    type Reading;

    /// Reads a tracklet's crops. `values` have the robot in the frame of its pose at the first sighting, and the object as track 0.
    ///
    /// # Errors
    /// A model that does not fit.
    fn read(
        &self,
        problem: &Problem<'_>,
        values: &Values,
        sightings: &[Sighting],
    ) -> Result<Self::Reading, AnswerError>;

    /// `log p(crops | all of one object) - log p(crops | each of another)`, nats, of readings each with the heading of its frame.
    fn log_ratio(&self, readings: &[(&Self::Reading, Heading)]) -> f64;
}

/// The heading of the frame that something was read in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heading {
    /// About the world's z axis, radians.
    pub yaw: f64,
    /// Its variance.
    pub variance: f64,
}

/// Crops say nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Blind;

impl Likeness for Blind {
    type Reading = ();

    fn read(&self, _: &Problem<'_>, _: &Values, _: &[Sighting]) -> Result<(), AnswerError> {
        Ok(())
    }

    fn log_ratio(&self, _: &[(&(), Heading)]) -> f64 {
        0.0
    }
}
