//! The associators: what each makes of tracklets whose objects nobody names.
//!
//! A new one is a file here.

mod encoded;
mod hypothesizing;
mod likeness;
mod scan;
mod sensing;
mod separate;

pub use encoded::{Encoded, EncodedSettings};
pub use hypothesizing::{AssociationSettings, Hypothesizing};
pub use likeness::{Blind, Heading, Likeness};
pub use separate::Separate;

use crate::input::EstimateError;
use std::time::Duration;
use vantage_dataset::Tracklets;

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
}

/// One way to tell who is who.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedPartition {
    /// Its probability, if the associator has any.
    pub weight: f64,
    /// Of each tracklet, the number of its object; none of one that is of nothing. Equal numbers are one object.
    pub objects: Vec<Option<usize>>,
}

impl Association {
    /// Without any doubt.
    pub fn certain(objects: Vec<Option<usize>>) -> Self {
        Self { hypotheses: vec![WeightedPartition { weight: 1.0, objects }], times: Vec::new() }
    }

    /// The likeliest objects of tracklets; nothing where there are no hypotheses.
    pub fn objects(&self) -> &[Option<usize>] {
        self.hypotheses.first().map_or(&[], |best| &best.objects)
    }
}
