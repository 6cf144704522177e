//! What one method made of one seed.

use crate::result::metric::Metric;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::Seed;

/// One method on one seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// The method.
    pub method: String,
    /// The seed of the episode, or of the trial.
    pub seed: Seed,
    /// How it ended.
    pub outcome: Outcome,
    /// Its scores, SI units; an undefined score is absent.
    pub scores: BTreeMap<Metric, f64>,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// As it should.
    Done,
    /// With an answer, but not as it should (an iteration limit, an under-constrained variable): scored and counted.
    Flagged(String),
    /// Without an answer: no scores, but counted.
    Failed(String),
}

impl Run {
    /// Why there is no answer, where there is none.
    pub fn failure(&self) -> Option<&str> {
        match &self.outcome {
            Outcome::Failed(reason) => Some(reason),
            _ => None,
        }
    }
}
