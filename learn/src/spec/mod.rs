//! `model`: what is trained, and how.

mod frames;
mod objective;
mod predictive;

pub use frames::Frames;
pub use objective::Objective;
pub(crate) use objective::{Loss, Task, Traits};
pub use predictive::{Motion, Pairs, PredictiveSpec, TrunkTarget};

use crate::role::Convention;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;
use vantage_dataset::viewpoint::HARMONICS;

/// How the instance term ties a latent `e` to its instance `beta`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InstanceTerm {
    /// `P(e | beta)` of Eq. 14: pulls the latents of an instance together.
    Likelihood,
    /// `P(beta | e)` of Eq. 13, normalised over the training instances: also pushes those of others apart.
    #[default]
    Posterior,
}

/// The class term of Eq. 21-24. Every field has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields, default)]
pub struct ClassSpec {
    /// Share of the training instances whose class is known.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub tagged: f64,
    /// Standard deviation of the latents of a class around its mean, invariant part only.
    #[garde(range(min = 1e-3, max = 1e3), custom(not_nan))]
    pub sigma: f64,
}

/// A training. Every field has a default; those of `pairs_per_harmonic` and `trunk_instance_weight` were chosen on
/// validation instances (`studies/choice.yaml`), the instance term is Eq. 13 as printed
/// (`results/studies/reference/README.md` says why).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingSpec {
    /// What is trained.
    #[garde(skip)]
    #[serde(skip_serializing_if = "is_default")]
    pub objective: Objective,
    /// Pairs of numbers of the latent that turn with each of the five harmonics of the azimuth; the others do not turn. With 0
    /// none does; at most 64. Models that are told of no azimuth have none.
    #[garde(custom(leaves_invariant(self)))]
    pub pairs_per_harmonic: usize,
    /// In which frame of the object azimuths are told.
    #[garde(skip)]
    #[serde(skip_serializing_if = "is_default")]
    pub frames: Frames,
    /// Of the viewpoint-predictive model.
    #[garde(dive)]
    #[serde(skip_serializing_if = "is_default")]
    pub predictive: PredictiveSpec,
    /// The class term; without it no training reads a class.
    #[garde(dive)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<ClassSpec>,
    /// Steps that train the trunk, whose features become the reduced measurement.
    #[garde(range(min = 1, max = 1_000_000))]
    pub trunk_steps: u32,
    /// Weight, beside the trunk's loss of viewpoints, of an InfoNCE loss that tells instances apart by association; 0 by default. With it a
    /// step's crops are pairs, one pair of each of as many different instances (sessions, of a camera's motion) as there are or
    /// fit; of changes of azimuth, four views of each session in place of eight. Not for `autoencoder` and `contrastive`.
    #[garde(range(min = 0.0, max = 1e3), custom(not_nan), custom(beside_viewpoints(self)))]
    #[serde(skip_serializing_if = "is_default")]
    pub trunk_instance_weight: f64,
    /// Strength by which the crops of a step of the trunk are altered, 0 by default: each gets a gain of `exp(-strength)` to `exp(strength)`, a
    /// fifth of that for each channel, and is moved by up to `4 strength` pixels each way.
    #[garde(range(min = 0.0, max = 2.0), custom(not_nan))]
    #[serde(skip_serializing_if = "is_default")]
    pub trunk_augmentation: f64,
    /// Crops in a step of the trunk.
    #[garde(range(min = 1, max = 4096))]
    pub trunk_batch: u32,
    /// Steps that train encoder and decoder on the trunk's features.
    #[garde(range(min = 1, max = 10_000_000))]
    pub steps: u32,
    /// Instances in a step.
    #[garde(range(min = 1, max = 4096))]
    pub batch: u32,
    /// Views of each instance in a step: all are predicted, from one latent. With 1, and 1 in `context`, the bound is that of
    /// Eq. 12 for a single view.
    #[garde(range(min = 1, max = 64))]
    pub views: u32,
    /// The latent is inferred from 1 to this many of the views.
    #[garde(range(min = 1, max = 64))]
    pub context: u32,
    /// Highest learning rate: reached after a short warm-up, then lowered along a cosine.
    #[garde(range(min = 1e-7, max = 1.0), custom(not_nan))]
    pub learning_rate: f64,
    /// Numbers in the latent vector of an object; at least the number of classes where that is one.
    #[garde(range(min = 1, max = 1024))]
    pub latent_dim: usize,
    /// Numbers in the reduced measurement of a crop.
    #[garde(range(min = 1, max = 256))]
    pub measurement_dim: usize,
    /// Numbers of the trunk's features, which the reduced measurement is made of: at least as many as that has; 256 by default.
    #[garde(range(min = 1, max = 1024), custom(hold_measurement(self)))]
    #[serde(skip_serializing_if = "is_usual_width")]
    pub features_dim: usize,
    /// Numbers in each of the decoder's two hidden layers; 256 by default.
    #[garde(range(min = 1, max = 1024))]
    #[serde(skip_serializing_if = "is_usual_width")]
    pub decoder_width: usize,
    /// Weight of the image's likelihood beside that of the reduced measurement.
    #[garde(range(min = 0.0, max = 100.0), custom(not_nan))]
    pub image_weight: f64,
    /// What the instance term is.
    #[garde(skip)]
    pub instance_term: InstanceTerm,
    /// Standard deviation of an instance's latents around its mean (Eq. 14), invariant part only.
    #[garde(range(min = 1e-3, max = 1e3), custom(not_nan))]
    pub instance_sigma: f64,
    /// Weight of the instance term: 1 in the bound as printed; 0 leaves it out.
    #[garde(range(min = 0.0, max = 1e3), custom(not_nan))]
    pub instance_weight: f64,
    /// Steps between two checkpoints, from which an interrupted training goes on.
    #[garde(range(min = 1, max = 1_000_000))]
    pub checkpoint_every: u32,
}

impl Default for ClassSpec {
    fn default() -> Self {
        Self { tagged: 0.1, sigma: 1.0 }
    }
}

impl Default for TrainingSpec {
    fn default() -> Self {
        Self {
            objective: Objective::default(),
            pairs_per_harmonic: 2,
            frames: Frames::default(),
            predictive: PredictiveSpec::default(),
            class: None,
            trunk_steps: 2000,
            trunk_instance_weight: 0.0,
            trunk_augmentation: 0.0,
            trunk_batch: 128,
            steps: 3000,
            batch: 48,
            views: 8,
            context: 7,
            learning_rate: 1e-3,
            latent_dim: 128,
            measurement_dim: 32,
            features_dim: USUAL_WIDTH,
            decoder_width: USUAL_WIDTH,
            image_weight: 1.0,
            instance_term: InstanceTerm::default(),
            instance_sigma: 1.0,
            instance_weight: 1.0,
            checkpoint_every: 250,
        }
    }
}

impl TrainingSpec {
    /// What tells the objective from the others.
    pub(crate) fn traits(&self) -> Traits {
        let traits = self.objective.traits(&self.predictive);
        let relative = self.frames == Frames::None && traits.task == Task::Viewpoint;
        Traits { task: if relative { Task::Change } else { traits.task }, ..traits }
    }

    /// Whether the model tells what an object looks like from a viewpoint, as scores of viewpoints and estimators need it:
    /// see [`Model::viewing`](crate::Model::viewing).
    pub fn is_viewing(&self) -> bool {
        match self.traits().convention {
            Some(Convention::AzimuthHarmonics) => true,
            _ => self.turning_pairs() > 0,
        }
    }

    /// Whether changes between views are what the model is told, which a robot knows by its odometry.
    pub(crate) fn reads_odometry(&self) -> bool {
        self.traits().convention.is_some_and(|convention| convention != Convention::AzimuthHarmonics)
    }

    /// Pairs of the latent for each harmonic: none where it is a class, or where no azimuth is told.
    pub(crate) fn turning_pairs(&self) -> usize {
        let Traits { convention, loss, .. } = self.traits();
        let turns = convention.is_some_and(Convention::turns) && loss != Loss::Class;
        if turns { self.pairs_per_harmonic } else { 0 }
    }
}

// Settings that came later do not enter the hash of scenes that leave them as they were.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

const USUAL_WIDTH: usize = 256;

fn is_usual_width(width: &usize) -> bool {
    *width == USUAL_WIDTH
}

/// Most pairs for each harmonic: what turns derivatives are matrices of the square of all pairs.
pub(crate) const MOST_PAIRS: usize = 64;

fn leaves_invariant(spec: &TrainingSpec) -> impl FnOnce(&usize, &()) -> garde::Result + '_ {
    move |pairs, ()| {
        let (latent, least) =
            (spec.latent_dim, spec.turning_pairs().saturating_mul(2 * HARMONICS).saturating_add(1));
        if spec.turning_pairs() > MOST_PAIRS {
            return Err(garde::Error::new(format!("is {pairs}, it has to be at most {MOST_PAIRS}")));
        }
        if latent >= least {
            return Ok(());
        }
        Err(garde::Error::new(format!("latent_dim is {latent}: with {pairs} it has to be at least {least}")))
    }
}

fn hold_measurement(spec: &TrainingSpec) -> impl FnOnce(&usize, &()) -> garde::Result + '_ {
    move |&features, ()| {
        let measurement = spec.measurement_dim;
        if features >= measurement {
            return Ok(());
        }
        Err(garde::Error::new(format!(
            "is {features}: with a measurement_dim of {measurement} it has to be at least that"
        )))
    }
}

fn beside_viewpoints(spec: &TrainingSpec) -> impl FnOnce(&f64, &()) -> garde::Result + '_ {
    move |&weight, ()| {
        if weight == 0.0 || spec.traits().convention.is_some() {
            return Ok(());
        }
        Err(garde::Error::new(format!(
            "is {weight}: the objectives autoencoder and contrastive, whose trunks learn no viewpoints, do not take it; set it to 0"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid_and_fields_are_checked() {
        let spec = TrainingSpec::default();
        spec.validate().unwrap();
        let wrong = TrainingSpec { latent_dim: 20, learning_rate: f64::NAN, views: 0, ..spec.clone() };
        let report = wrong.validate().unwrap_err().to_string();
        for field in ["pairs_per_harmonic", "21", "learning_rate", "views"] {
            assert!(report.contains(field), "{report}");
        }
        let pairs =
            |pairs_per_harmonic| TrainingSpec { pairs_per_harmonic, latent_dim: 1024, ..spec.clone() };
        pairs(MOST_PAIRS).validate().unwrap();
        assert!(pairs(MOST_PAIRS + 1).validate().unwrap_err().to_string().contains("at most 64"));
    }

    #[test]
    fn a_trunk_that_learns_no_viewpoints_learns_no_instances_beside_them() {
        let all = [
            (Objective::ViewpointDependent, true),
            (Objective::DiscreteClass, true),
            (Objective::ViewpointPredictive, true),
            (Objective::Autoencoder, false),
            (Objective::Contrastive, false),
        ];
        for (objective, takes_it) in all {
            let spec = TrainingSpec { objective, trunk_instance_weight: 0.5, ..TrainingSpec::default() };
            let told = spec.validate().map_err(|report| report.to_string());
            assert_eq!(told.is_ok(), takes_it, "{objective:?}");
            assert!(told.err().is_none_or(|told| told.contains("trunk_instance_weight: is 0.5")));
        }
    }

    #[test]
    fn strengths_of_augmentation_are_checked_and_written_where_crops_are_altered() {
        let altered = |trunk_augmentation| TrainingSpec { trunk_augmentation, ..TrainingSpec::default() };
        altered(2.0).validate().unwrap();
        for strength in [-0.1, 2.1, f64::NAN] {
            assert!(altered(strength).validate().unwrap_err().to_string().contains("trunk_augmentation"));
        }
        let written = |strength| serde_json::to_string(&altered(strength)).unwrap();
        assert!(
            written(0.5).contains(r#""trunk_augmentation":0.5"#) && !written(0.0).contains("augmentation")
        );
    }

    #[test]
    fn missing_fields_have_defaults_and_unknown_ones_are_refused() {
        let spec: TrainingSpec = serde_json::from_str(r#"{"steps": 7}"#).unwrap();
        assert_eq!(spec, TrainingSpec { steps: 7, ..TrainingSpec::default() });
        assert!(serde_json::from_str::<TrainingSpec>(r#"{"step": 7}"#).is_err());
    }

    #[test]
    fn sizes_of_networks_are_checked_and_written_where_they_are_not_the_usual() {
        let narrow = TrainingSpec { features_dim: 128, decoder_width: 192, ..TrainingSpec::default() };
        let architecture = crate::architecture::Architecture::new(&narrow).unwrap();
        assert_eq!((architecture.features, architecture.decoder), (128, vec![192, 192]));
        let written = |spec: &TrainingSpec| serde_json::to_string(spec).unwrap();
        assert!(written(&narrow).contains(r#""features_dim":128,"decoder_width":192"#));
        assert!(!written(&TrainingSpec::default()).contains("256"));
        assert_eq!(serde_json::from_str::<TrainingSpec>(&written(&narrow)).unwrap(), narrow);
        let told = |spec: TrainingSpec| spec.validate().unwrap_err().to_string();
        let report = told(TrainingSpec { features_dim: 1025, decoder_width: 0, ..narrow.clone() });
        assert!(report.contains("features_dim") && report.contains("decoder_width"), "{report}");
        let report = told(TrainingSpec { features_dim: 31, measurement_dim: 32, ..narrow });
        assert!(report.contains("features_dim: is 31: with a measurement_dim of 32"), "{report}");
    }
}
