//! A hypothesis of a map: what is expected of one row beside another.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use vantage_dataset::rule::not_nan;

/// What is expected of the ATE of a row beside that of another, on the same seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Hypothesis {
    /// In words.
    #[garde(length(min = 1, max = 300))]
    pub says: String,
    /// The panel.
    #[garde(skip)]
    pub panel: String,
    /// The values of the field along the panel whose cells count, averaged on each seed.
    #[garde(length(min = 1))]
    pub at: Vec<Value>,
    /// The row, as tables name it.
    #[garde(length(min = 1))]
    pub row: String,
    /// The row beside which it stands.
    #[garde(length(min = 1))]
    pub than: String,
    /// The panel of that row, where it is another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub than_in: Option<String>,
    /// What is expected.
    #[garde(dive)]
    pub expects: Expectation,
}

/// What is expected of a difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Expectation {
    /// A smaller ATE.
    Less,
    /// A larger ATE.
    More,
    /// An ATE that is larger by less than so many metres, or smaller.
    AtMost(#[garde(range(min = 0.0, max = 100.0), custom(not_nan))] f64),
    /// An ATE that differs by less than so many metres, up or down.
    Within(#[garde(range(min = 0.0, max = 100.0), custom(not_nan))] f64),
}
