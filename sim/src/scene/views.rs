//! `views`: the pictures of single objects that the model is trained on.

use crate::scene::rule::{Interval, interval_within};
use crate::scene::sensors::OdometrySpec;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Split;
use vantage_dataset::rule::not_nan;

/// Pictures of single objects with known viewpoints, for training and calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct ViewsSpec {
    /// Instances that train the model.
    #[garde(range(min = 1))]
    pub train_instances: u32,
    /// Instances that calibrate the noise of the measurement.
    #[garde(range(min = 1))]
    pub validation_instances: u32,
    /// Instances that viewpoints, clustering and retrieval are scored on, for each seed.
    #[garde(range(min = 1))]
    pub test_instances: u32,
    /// Views of each instance, spread evenly over its sessions.
    #[garde(range(min = 1, max = 10_000))]
    pub views_per_instance: u32,
    /// Sessions of each instance: one light and one set of neighbours each.
    #[garde(range(min = 1, max = 1_000))]
    pub sessions: u32,
    /// Elevation of the camera above the horizontal plane through the object's centre, degrees.
    #[garde(custom(interval_within(0.5, 85.0)))]
    pub elevation_deg: Interval,
    /// Distance of the camera from the object's centre, metres; drawn evenly in its logarithm.
    #[garde(custom(interval_within(0.2, 50.0)))]
    pub distance: Interval,
    /// Standard deviation of the camera's roll, degrees.
    #[garde(range(min = 0.0, max = 20.0), custom(not_nan))]
    pub roll_sigma_deg: f64,
    /// Share of sessions in which other objects stand near, and may hide part of this one.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub occluder_probability: f64,
    /// Share of the training and validation instances that are composites in place of the world's kinds, spread evenly among them; 0
    /// by default. Test instances are the world's.
    #[serde(default, skip_serializing_if = "is_none")]
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub composites: f64,
    /// Odometry of a robot that goes from view to view of a session, by azimuth: what the viewpoint-predictive model is
    /// trained on. Without it views have no sightings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub odometry: Option<OdometrySpec>,
}

impl ViewsSpec {
    /// The setting that says how many instances a split has.
    pub fn field(split: Split) -> &'static str {
        match split {
            Split::Train => "views.train_instances",
            Split::Validation => "views.validation_instances",
            Split::Test => "views.test_instances",
        }
    }

    /// Whether an instance of a split is a composite, whatever the world's kinds are.
    pub fn is_composite(&self, split: Split, index: usize) -> bool {
        let among = |instances: usize| (instances as f64 * self.composites).floor();
        split != Split::Test && among(index + 1) > among(index)
    }

    /// How many instances a split has.
    pub fn instances(&self, split: Split) -> usize {
        let instances = match split {
            Split::Train => self.train_instances,
            Split::Validation => self.validation_instances,
            Split::Test => self.test_instances,
        };
        instances as usize
    }
}

// A setting that came later does not enter the hash of scenes that leave it out.
fn is_none(share: &f64) -> bool {
    *share == 0.0
}
