//! The panels of a map, and what runs in them.

use super::associator::AssociatedBy;
use super::is_file_name;
use super::life::Stretch;
use super::row::Row;
use super::vary::{Fields, of_a_cell};
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Panels and rows for a reader in a hurry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// The panels, by their names.
    #[garde(length(min = 1, max = 4))]
    pub panels: Vec<String>,
    /// The rows, as tables name them.
    #[garde(length(min = 1))]
    pub rows: Vec<String>,
}

/// Rows that read crops by one model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Estimates {
    /// The rows.
    #[garde(length(min = 1))]
    pub rows: Vec<Row>,
    /// Folder of the model, relative to the map; without it, that of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub model: Option<PathBuf>,
    /// Who tells these rows which object a detection is of; without it, the episode does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub association: Option<AssociatedBy>,
    /// Fields of `estimator` that these rows have otherwise than the scene.
    #[serde(default, skip_serializing_if = "Fields::is_empty")]
    #[garde(custom(of_the_estimator))]
    pub set: Fields,
}

/// The scene with some fields replaced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// Its name in tables.
    #[garde(custom(is_file_name))]
    pub name: String,
    /// Its title in figures.
    #[garde(length(min = 1, max = 60))]
    pub title: String,
    /// Fields of the scene that are replaced.
    #[serde(default)]
    #[garde(custom(of_a_cell))]
    pub set: Fields,
    /// Where drives follow each other, their worlds: rows that learn go on from what the drives before taught.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[garde(length(max = 50), dive)]
    pub life: Vec<Stretch>,
    /// Whether each drive is a first one, of which those before taught nothing.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[garde(skip)]
    pub alone: bool,
    /// What runs in its cells, in place of what runs in all others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive, custom(not_empty))]
    pub estimates: Option<Vec<Estimates>>,
}

fn of_the_estimator(set: &Fields, _: &()) -> garde::Result {
    match set.keys().find(|field| !field.starts_with("estimator.") || *field == "estimator.rows") {
        Some(field) => {
            Err(garde::Error::new(format!("{field}: expected fields of estimator, but `rows`, alone")))
        }
        None => Ok(()),
    }
}

fn not_empty(estimates: &Option<Vec<Estimates>>, _: &()) -> garde::Result {
    match estimates {
        Some(estimates) if estimates.is_empty() => {
            Err(garde::Error::new("got none, expected at least one; leave it out for those of the map"))
        }
        _ => Ok(()),
    }
}
