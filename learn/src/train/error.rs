//! Why a training stops short.

use super::run::progress::Stage;
use crate::error::ModelError;
use std::path::PathBuf;
use vantage_dataset::{InstanceId, Split};

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum TrainError {
    /// Fields of the spec out of range.
    #[error("training spec: {0}")]
    Spec(garde::Report),
    /// No GPU, where one was asked for.
    #[cfg(feature = "gpu")]
    #[error("wgpu finds no GPU (a software renderer is none): install its Vulkan driver, or leave --gpu out")]
    NoGpu,
    /// Views of another split than they are to be used for.
    #[error("views of split {got:?} given as {expected:?}")]
    Split { got: Split, expected: Split },
    /// Instances that both train and validate.
    #[error(
        "{} of the validation instances are among the training ones (first: {:016x}); split by instance",
        shared.len(), shared.first().map_or(0, |id| id.0)
    )]
    SharedInstances { shared: Vec<InstanceId> },
    /// A viewpoint that is NaN or infinite.
    #[error("view {view} of the {split:?} views has a viewpoint that is not finite")]
    Viewpoint { split: Split, view: usize },
    /// A view without what the viewpoint-predictive model is trained on.
    #[error(
        "view {view} of the {split:?} views has no sighting: the viewpoint-predictive model is trained on odometry; \
         set views.odometry in the scene"
    )]
    Sighting { split: Split, view: usize },
    /// Crops that tell nothing apart.
    #[error(
        "all crops of the {split:?} views are the same, such as black: look at them, and at what made them"
    )]
    SameCrops { split: Split },
    /// A view of an instance that the set does not list.
    #[error("view {view} of the {split:?} views is of instance {got}, of {instances} listed")]
    Instance { split: Split, view: usize, got: usize, instances: usize },
    /// More classes than a latent that is one has numbers.
    #[error("{got} classes, but latent_dim is {latent}: give it at least as many numbers")]
    Classes { got: usize, latent: usize },
    /// Too little to learn from.
    #[error("{got} instances of the {split:?} views have two views or more, expected at least {expected}")]
    TooFewInstances { split: Split, got: usize, expected: usize },
    /// Too few validation views to fit the noise of the measurement.
    #[error(
        "{got} validation residuals for {dimension} numbers, expected at least {expected} finite ones; give more validation views"
    )]
    Calibration { got: usize, dimension: usize, expected: usize },
    /// The loss is NaN or infinite.
    #[error("the loss of stage {stage} is {loss} at step {step}; lower the learning rate (log: {log:?})")]
    NonFiniteLoss {
        stage: Stage,
        /// The step; one more than the stage has where its last step broke the weights.
        step: usize,
        loss: f64,
        /// Where the curve up to this step is.
        log: PathBuf,
    },
    /// The progress callback asked to stop. The last checkpoint stays, and training goes on from it.
    #[error("stopped in stage {stage} at step {step}")]
    Stopped { stage: Stage, step: usize },
    /// The folder holds a finished model.
    #[error("{path:?} exists; train into another folder, or remove it")]
    AlreadyTrained { path: PathBuf },
    /// A file that cannot be written.
    #[error("cannot write {path:?}: {reason}")]
    Write { path: PathBuf, reason: String },
    /// The exported model does not load here, which is a fault of this crate.
    #[error("the exported model does not load: {0}")]
    Export(ModelError),
}
