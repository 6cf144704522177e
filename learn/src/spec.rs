//! `model`: how the viewpoint-dependent model is trained.

use crate::latent::LatentLayout;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Training of the viewpoint-dependent model. Every field has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingSpec {
    /// Steps that train the trunk, whose features become the reduced measurement.
    #[garde(range(min = 1, max = 1_000_000))]
    pub trunk_steps: u32,
    /// Crops in a step of the trunk.
    #[garde(range(min = 1, max = 4096))]
    pub trunk_batch: u32,
    /// Steps that train encoder and decoder on the trunk's features.
    #[garde(range(min = 1, max = 10_000_000))]
    pub steps: u32,
    /// Instances in a step.
    #[garde(range(min = 1, max = 4096))]
    pub batch: u32,
    /// Views of each instance in a step: all are predicted, from one latent.
    #[garde(range(min = 2, max = 64))]
    pub views: u32,
    /// The latent is inferred from 1 to this many of the views.
    #[garde(range(min = 1, max = 64))]
    pub context: u32,
    /// Highest learning rate: reached after a short warm-up, then lowered along a cosine.
    #[garde(range(min = 1e-7, max = 1.0), custom(not_nan))]
    pub learning_rate: f64,
    /// Numbers in the latent vector of an object.
    #[garde(range(min = LatentLayout::SMALLEST, max = 1024))]
    pub latent_dim: usize,
    /// Numbers in the reduced measurement of a crop.
    #[garde(range(min = 1, max = 256))]
    pub measurement_dim: usize,
    /// Weight of the image's likelihood beside that of the reduced measurement.
    #[garde(range(min = 0.0, max = 100.0), custom(not_nan))]
    pub image_weight: f64,
    /// Standard deviation of an instance's latents around its mean (Eq. 14), invariant part only.
    #[garde(range(min = 1e-3, max = 1e3), custom(not_nan))]
    pub instance_sigma: f64,
    /// Steps between two checkpoints, from which an interrupted training goes on.
    #[garde(range(min = 1, max = 1_000_000))]
    pub checkpoint_every: u32,
}

impl Default for TrainingSpec {
    fn default() -> Self {
        Self {
            trunk_steps: 2000,
            trunk_batch: 128,
            steps: 3000,
            batch: 48,
            views: 8,
            context: 7,
            learning_rate: 1e-3,
            latent_dim: 128,
            measurement_dim: 32,
            image_weight: 1.0,
            instance_sigma: 1.0,
            checkpoint_every: 250,
        }
    }
}

fn not_nan(value: &f64, _: &()) -> garde::Result {
    if value.is_nan() { Err(garde::Error::new("is not a number")) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid_and_fields_are_checked() {
        let spec = TrainingSpec::default();
        spec.validate().unwrap();
        let wrong = TrainingSpec { latent_dim: 10, learning_rate: f64::NAN, views: 1, ..spec };
        let report = wrong.validate().unwrap_err().to_string();
        for field in ["latent_dim", "learning_rate", "views"] {
            assert!(report.contains(field), "{report}");
        }
    }

    #[test]
    fn missing_fields_have_defaults_and_unknown_ones_are_refused() {
        let spec: TrainingSpec = serde_json::from_str(r#"{"steps": 7}"#).unwrap();
        assert_eq!(spec, TrainingSpec { steps: 7, ..TrainingSpec::default() });
        assert!(serde_json::from_str::<TrainingSpec>(r#"{"step": 7}"#).is_err());
    }
}
