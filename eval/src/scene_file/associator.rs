//! Associators, and what they are told: the rows of the table of associations.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Who tells which object a detection is of, in place of the episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct AssociatedBy {
    /// What it is told.
    #[garde(skip)]
    pub told: Told,
    /// The associator.
    #[garde(skip)]
    pub by: AssociatorRow,
}

/// What an associator is told of who is who.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Told {
    /// Which detections are of one object while that stays in view.
    Tracklets,
    /// Nothing.
    None,
}

/// An associator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AssociatorRow {
    /// No object is ever seen again.
    Separate,
    /// The nearest object within a gate, one tracklet after the other, for good.
    Nearest,
    /// The likeliest objects of a step's detections by geometry, for good.
    Greedy,
    /// The same, with the model's latents beside geometry.
    GreedyLatents,
    /// The same, with a contrastive embedding in their place.
    GreedyEmbedding,
    /// Expectation maximisation by geometry and latents.
    Em,
    /// A max-mixture with a null hypothesis, by geometry and latents.
    MaxMixture,
    /// Hypotheses by geometry.
    Hypotheses,
    /// Hypotheses by geometry and class.
    HypothesesClass,
    /// Hypotheses by geometry and latents: from which side an object is seen says nothing.
    HypothesesLatents,
    /// Hypotheses by geometry, latents and sides.
    HypothesesViews,
}

impl Told {
    /// All levels, the more telling first.
    pub const ALL: [Self; 2] = [Self::Tracklets, Self::None];
}

impl AssociatorRow {
    /// All, in the order of the table.
    pub const ALL: [Self; 11] = [
        Self::Separate,
        Self::Nearest,
        Self::Greedy,
        Self::GreedyLatents,
        Self::GreedyEmbedding,
        Self::Em,
        Self::MaxMixture,
        Self::Hypotheses,
        Self::HypothesesClass,
        Self::HypothesesLatents,
        Self::HypothesesViews,
    ];
}

/// As the table of associations names it.
impl fmt::Display for AssociatedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.told, self.by)
    }
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl fmt::Display for AssociatorRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}
