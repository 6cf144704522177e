//! The estimator: the posterior of Eq. 1-10 as a factor graph, its maximum and its marginals.
//!
//! ```text
//! P(X, O, E | H)  is proportional to  prod_k  P(x_k | x_k-1, u_k-1)        factor::between, Eq. 4
//!                                     prod_ki P(z^g_ki | x_k, o_i)         factor::bearing, Eq. 6
//!                                     prod_ki P(z^s_ki | e_i, x_rel_ki)    factor::semantic, Eq. 9-10
//!                                     prod_i  P(o_i) P(e_i)                factor::{upright, prior}
//! ```
//!
//! | symbol | module |
//! |---|---|
//! | X, O, E: SE(3) poses, points, latent vectors | [`variable`] |
//! | P(z \| ...): whitened residuals and kernels | [`noise`], [`factor`] |
//! | the product | [`graph`] |
//! | J^T W J, latents eliminated inside their own object | [`linear`] |
//! | argmax | [`solve`] |
//! | marginal covariances | [`covariance`] |
//! | p(z \| e, x_rel), q(e \| z, x_rel) | [`observation_model`] |
//! | start values | [`initial`], [`mapping`], [`orientation`] |
//! | rows of the score table | [`spec`], [`input`], [`sighting`], [`semantics`], [`problem`], [`estimator`], [`mod@estimate`] |
//!
//! The world frame is that of the robot's first pose, whose z axis points up. Tangents are rotation first,
//! perturbations on the right (`T * Exp(xi)`). No ground truth comes in: the input is
//! [`vantage_dataset::Observations`].

pub mod covariance;
pub mod estimate;
pub mod estimator;
pub mod factor;
pub mod graph;
pub mod initial;
pub mod input;
pub mod linear;
pub mod mapping;
pub mod noise;
pub mod observation_model;
pub mod orientation;
pub mod problem;
pub mod se3_jacobian;
pub mod semantics;
pub mod sighting;
pub mod solve;
pub mod spec;
pub mod variable;

pub use estimate::{Dropped, Estimate, ObjectEstimate, Orientation, Unresolved, UnresolvedReason};
pub use estimator::estimate;
pub use input::EstimateError;
pub use observation_model::{LatentGaussian, Linearization, MeasurementNoise, ModelError, ObservationModel};
pub use solve::Outcome;
pub use spec::{EstimatorSpec, Row};
pub use variable::Key;
