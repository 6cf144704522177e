//! `model.frames`: in which frame of the object a training is told viewpoints.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The frame of each object that azimuths are told in. The viewpoint-predictive model is told none, whatever this says, but by
/// `predictive.trunk: true_viewpoints`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Frames {
    /// That of its family, where the front is.
    #[default]
    Canonical,
    /// One of its own, turned at random: nothing tells where the front is.
    Random,
    /// None: as `random`, and the trunk learns changes of azimuth between an object's views, not azimuths.
    None,
}
