//! What crops tell of who is who.

use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::Values;
use vantage_model::AnswerError;

/// Whether crops are of one object.
pub trait Likeness: Sync {
    /// What is read of one tracklet, whatever it is of.
    type Reading;
    /// Readings taken together as of one object.
    type Sum: Clone + Default;

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

    /// Takes in one reading more, with the heading of its frame.
    fn add(&self, sum: &mut Self::Sum, reading: &Self::Reading, heading: Heading);

    /// `log p(crops | all of one object) - log p(crops | each of another)`, nats, of all that was taken in.
    fn log_ratio(&self, sum: &Self::Sum) -> f64;

    /// The same of readings each with the heading of its frame.
    fn log_ratio_of(&self, readings: &[(&Self::Reading, Heading)]) -> f64 {
        let mut sum = Self::Sum::default();
        readings.iter().for_each(|(reading, heading)| self.add(&mut sum, reading, *heading));
        self.log_ratio(&sum)
    }
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
    type Sum = ();

    fn read(&self, _: &Problem<'_>, _: &Values, _: &[Sighting]) -> Result<(), AnswerError> {
        Ok(())
    }

    fn add(&self, (): &mut (), (): &(), _: Heading) {}

    fn log_ratio(&self, (): &()) -> f64 {
        0.0
    }
}
