//! `model.predictive`: settings of the viewpoint-predictive model alone.

use super::is_default;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// What the viewpoint-predictive model is told of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// The change of viewpoint about the object's centre.
    #[default]
    ObjectCentred,
    /// The camera's motion, as in Eq. 15.
    Camera,
    /// The true change of viewpoint about the object's centre: what odometry's errors cost.
    TrueObjectCentred,
}

/// Which views of a session make pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pairs {
    /// Any two.
    #[default]
    Wide,
    /// Those that follow each other, as in Eq. 18.
    Adjacent,
}

/// What the trunk of the viewpoint-predictive model learns from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrunkTarget {
    /// Changes between the views of a session, as `motion` tells them.
    #[default]
    Motions,
    /// True viewpoints, as the viewpoint-dependent model's trunk does: what it costs to do without them.
    TrueViewpoints,
}

/// The viewpoint-predictive model's own settings. Every field has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields, default)]
pub struct PredictiveSpec {
    /// What the decoder is told of a motion.
    #[garde(skip)]
    pub motion: Motion,
    /// Which views make pairs.
    #[garde(skip)]
    pub pairs: Pairs,
    /// What the trunk learns from; `motions` by default.
    #[garde(skip)]
    #[serde(skip_serializing_if = "is_default")]
    pub trunk: TrunkTarget,
    /// Share of predictions that see the reduced measurement of the first view beside the latent, as Eq. 15 has it. Less than 1, since
    /// calibration, scores and the estimator ask without a first view.
    #[garde(range(min = 0.0, max = 0.9), custom(not_nan))]
    pub source: f64,
}

impl Default for PredictiveSpec {
    fn default() -> Self {
        Self {
            motion: Motion::default(),
            pairs: Pairs::default(),
            trunk: TrunkTarget::default(),
            source: 0.5,
        }
    }
}
