//! What results are of.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What results are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ResultKind {
    /// A scene.
    Scene,
    /// A study.
    Study,
}

impl fmt::Display for ResultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scene => "scene",
            Self::Study => "study",
        })
    }
}
