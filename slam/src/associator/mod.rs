//! The associators: what each makes of tracklets whose objects nobody names.
//!
//! A new one is a file here.

mod alternating;
mod classed;
mod copies;
mod embedded;
mod encoded;
mod hypothesizing;
mod likeness;
mod ratios;
mod reading;
mod relocation;
mod scan;
mod sensing;
mod separate;
mod tracklet;
mod view;

pub use alternating::{Alternating, Weights};
pub use classed::{Classed, ClassedSettings};
pub use embedded::{Embedded, EmbeddedSettings};
pub use encoded::{Encoded, EncodedSettings};
pub use hypothesizing::{AssociationSettings, Hypothesizing};
pub use likeness::{Blind, Heading, Likeness};
pub use separate::Separate;

use crate::input::EstimateError;
use std::time::Duration;
use vantage_dataset::{Pose, Tracklets};

/// Which tracklets are of one object.
pub trait Associator: Sync {
    /// An answer, and what else may be so.
    ///
    /// # Errors
    /// Bad input, and a model that does not fit.
    fn associate(&self, seen: &Tracklets) -> Result<Association, EstimateError>;
}

/// Hypotheses over the objects of tracklets.
#[derive(Clone, Debug, Default)]
pub struct Association {
    /// The likeliest first; at least one. Weights add up to 1.
    pub hypotheses: Vec<WeightedPartition>,
    /// How long each step took.
    pub times: Vec<Duration>,
    /// Where the robot was believed to be at each step when it was there.
    pub places: Vec<Place>,
}

/// Where a robot believes to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// In the frame of its first pose.
    pub world_from_robot: Pose,
    /// False where it was carried and has not seen anything of its map again.
    pub is_known: bool,
}

/// One way to tell who is who.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedPartition {
    /// Its probability, if the associator has any.
    pub weight: f64,
    /// Of each tracklet, the number of its object; none of one that is of nothing. Equal numbers are one object.
    pub objects: Vec<Option<usize>>,
}

impl Place {
    /// Distance within which two places are one, metres.
    const REACH: f64 = 0.5;

    /// Whether two places are one: near each other, or both unknown.
    fn is_about(&self, other: &Self) -> bool {
        let apart =
            (self.world_from_robot.translation.vector - other.world_from_robot.translation.vector).norm();
        self.is_known == other.is_known && (!self.is_known || apart < Self::REACH)
    }
}

impl Association {
    /// Without any doubt.
    pub fn certain(objects: Vec<Option<usize>>) -> Self {
        Self { hypotheses: vec![WeightedPartition { weight: 1.0, objects }], ..Self::default() }
    }

    /// The likeliest objects of tracklets; nothing where there are no hypotheses.
    pub fn objects(&self) -> &[Option<usize>] {
        self.hypotheses.first().map_or(&[], |best| &best.objects)
    }
}
