//! Which object was seen, and where the robot is: hypotheses over assignments, weighted by their evidence.
//!
//! ```text
//! P(h | Z)  is proportional to  P(h)  integral of  prod_f exp(-cost_f(x; h)) dx      by Laplace's method, over all variables
//! ```
//!
//! | symbol | module |
//! |---|---|
//! | a measurement that may be taken in several ways, with `log P` of each | [`choice`] |
//! | what one adds, once a choice is to be judged: a joint marginal, a low-rank update | [`local`] |
//! | `h`, and which are kept | [`hypothesis`], [`hypotheses`], [`limits`], [`account`] |
//! | the integral under one `h`; any estimator that can do it, and the one that copies share | [`estimator`], [`smoother`] |
//! | planar worlds | [`planar`] |
//!
//! A hypothesis is one history of verdicts with an estimate of its own, linearised about its own values. Copies of an estimate share all fronts of
//! the factorisation that neither of them has changed, so that a branch costs what it changes. See `docs/association.md`.

pub mod account;
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
mod whole;

pub use account::{AssociationError, GivenUp, Work};
pub use choice::{Alternative, Choice, Frame, Verdict};
pub use estimator::{Addition, LocalEstimator, Moved, Unsolved};
pub use hypotheses::Hypotheses;
pub use hypothesis::Hypothesis;
pub use limits::{Limits, Merging};
pub use local::{Local, Weighed};
pub(crate) use mass::log_sum;
pub use smoother::{SharedSmoother, Thresholds};
