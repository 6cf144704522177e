//! Which object was seen: hypotheses over assignments, weighted by their evidence.

pub mod choice;
pub mod estimator;
mod expansion;
mod front;
pub mod hypotheses;
pub mod hypothesis;
pub mod limits;
pub mod local;
mod marginal;
mod mass;
mod order;
mod places;
pub mod planar;
pub mod shared;
pub mod smoother;
mod tree;

pub use choice::{Alternative, Choice, Frame, Verdict};
pub use estimator::{Addition, LocalEstimator, Unsolved};
pub use hypotheses::{AssociationError, GivenUp, Hypotheses, Work};
pub use hypothesis::Hypothesis;
pub use limits::{Limits, Merging};
pub use local::{Local, Weighed};
pub use smoother::{SharedSmoother, Thresholds};
