//! What a training tells while it runs.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The stages that descend a loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The trunk, under the viewpoint head.
    Trunk,
    /// Encoder and decoder, on the frozen trunk.
    Autoencoder,
}

impl Stage {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Trunk => "trunk",
            Stage::Autoencoder => "autoencoder",
        }
    }
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// What happened just now.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// A checkpoint was found.
    Resumed {
        /// The stage it lies in.
        stage: Stage,
        /// Steps of it that are done.
        step: usize,
    },
    /// A checkpoint was found, but is damaged or of another training; it was renamed and training starts anew.
    SetAside {
        /// Where it is now.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A step was made.
    Step {
        /// The stage.
        stage: Stage,
        /// Steps done.
        step: usize,
        /// Steps of the stage.
        steps: usize,
        /// Loss of this step.
        loss: f64,
    },
    /// The crops pass the frozen trunk, once.
    Features,
    /// The noise of the measurement is fitted on the validation views.
    Calibration,
    /// The folder is written and loaded back.
    Export,
}
