//! What results are of.

use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What results are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ResultKind {
    /// A scene.
    Scene,
    /// A study.
    Study,
    /// A map.
    Map,
}

impl ResultKind {
    /// The folder below `out` that results of `name` lie in.
    pub fn place(self, out: &Path, name: &str) -> PathBuf {
        let kind = match self {
            Self::Scene => "scenes",
            Self::Study => "studies",
            Self::Map => "maps",
        };
        out.join(kind).join(name)
    }
}
