//! The estimators: what each makes of an episode, composed of the same problems, factors and solver.
//!
//! A new one is a file here.

mod azimuth_head;
mod checked;
mod decoder_adapted;
mod decoder_checked;
mod discrete_class;
mod domain_adapted;
mod geometric;
mod hidden_views;
mod hypotheses;
mod odometry;
mod pairs;
mod process_refitted;
mod refitted;
mod semantic;
mod uninformative;

pub use azimuth_head::AzimuthHead;
pub use checked::Checked;
pub use decoder_adapted::{DecoderAdapted, DecoderTaught};
pub use decoder_checked::DecoderChecked;
pub use discrete_class::DiscreteClass;
pub use domain_adapted::DomainAdapted;
pub use geometric::Geometric;
pub use odometry::OdometryOnly;
pub use pairs::ViewpointPairs;
pub use process_refitted::{PROCESS_SIZES, ProcessRefitted};
pub use refitted::Refitted;
pub use semantic::{SeenView, Semantic};
pub use uninformative::Uninformative;

use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::Lesson;
use crate::online::Online;
use crate::solve::Outcome;
use vantage_dataset::{Camera, Observations, Pose};

/// P(X, O, E | H) of an episode, by some of its factors.
pub trait Estimator: Sync {
    /// The posterior's maximum and its marginals.
    ///
    /// Bad input and a model that does not fit are errors; a problem that has no good answer (nothing observed,
    /// under-constrained, diverged) is an [`Outcome`] with the best values there are.
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError>;

    /// The same posterior after every step of a robot with a camera, from nothing observed yet; `None` of an estimator that only takes
    /// whole episodes.
    fn online(&self, _camera: Camera, _robot_from_camera: Pose) -> Option<Result<Online<'_>, EstimateError>> {
        None
    }
}

/// What a drive taught.
pub struct Learnt {
    /// The estimate of the drive.
    pub estimate: Estimate,
    /// What is known after it.
    pub lesson: Lesson,
    /// `log p(Z | before) - log p(Z | the model as it was trained)` of all crops that are read, nats a crop: how much better they were known
    /// before they were seen, by Laplace's method. `None` where no crop is read, either evidence is not defined or is of no maximum, or
    /// they are of another number of crops of an object.
    pub gain: Option<f64>,
}

/// An estimator that goes on from what earlier drives taught.
pub trait Learner: Estimator {
    /// A drive after those that taught `before`.
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError>;
}

/// The log-evidence of one way to read a drive's crops over that of another, nats a crop.
fn gain_a_crop(own: (&Estimate, Option<f64>), other: (&Estimate, Option<f64>)) -> Option<f64> {
    let (of_own, of_other) = (crops_read(own.0), crops_read(other.0));
    let crops: usize = of_own.iter().sum();
    let is_defined = crops > 0 && of_own == of_other && is_at_maximum(own.0) && is_at_maximum(other.0);
    is_defined.then_some((own.1? - other.1?) / crops as f64)
}

/// Of each object, how many crops are read.
fn crops_read(estimate: &Estimate) -> Vec<usize> {
    estimate.objects.iter().map(|object| object.as_ref().map_or(0, |of| of.semantic_views)).collect()
}

/// Whether the solver came to a maximum, near which a posterior is what it is taken for.
fn is_at_maximum(estimate: &Estimate) -> bool {
    matches!(estimate.outcome, Outcome::Converged | Outcome::Stalled)
}
