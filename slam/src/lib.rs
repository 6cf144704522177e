//! The estimators: the posterior of Eq. 1-10 as a factor graph, its maximum and its marginals.
//!
//! ```text
//! P(X, L, O, E | H)  is proportional to  prod_k  P(x_k | x_k-1, u_k-1)        factor::between, Eq. 3
//!                                     prod_ki P(z^g_ki | x_k, o_i)         factor::{bearing, box_edges, depth}, Eq. 6
//!                                     prod_kj P(z^g_kj | x_k, l_j)         factor::projection, Eq. 6
//!                                     prod_ki P(z^s_ki | e_i, x_rel_ki)    factor::semantic, Eq. 9-10
//!                                  or P(z^s_k'i | z^s_ki, e_i, Delta X)    factor::pair, Eq. 15
//!                                     prod_i  P(o_i) P(e_i)                factor::{upright, prior}
//! ```
//!
//! | symbol | module |
//! |---|---|
//! | which of the factors: one file an estimator | [`mod@estimator`] |
//! | X, L, O, E: SE(3) poses, points, latent vectors | [`variable`] |
//! | U, Z^g, Z^s as factors | [`problem`], [`odometry_bias`], [`sighting`], [`bearing_offset`], [`semantics`] |
//! | P(z \| ...): whitened residuals and kernels | [`noise`], [`factor`] |
//! | what a model gets wrong of an object | [`discrepancy`] |
//! | which views are predicted from which (Eq. 15) | [`pairing`], [`noisy_first`] |
//! | what an episode differs in from training, learnt beside it (Eq. 25-26) | [`domain`] |
//! | whether it knows the object at all | [`unknown_object`], [`laplace`] |
//! | what a run teaches of the model | [`domain`], [`Refitted`], [`Checked`], [`DecoderChecked`] |
//! | what drives teach, from one to the next | [`mod@lesson`], [`Learner`], [`DomainAdapted`], [`DecoderAdapted`] |
//! | draws of the posterior | [`mod@draws`] |
//! | p(z \| e, x_rel), q(e \| z, x_rel), p(z' \| z, e, Delta X) | [`vantage_model::ObservationModel`], [`vantage_model::PairModel`] |
//! | the product | [`graph`] |
//! | objects as ellipsoids | [`mod@extents`] |
//! | start values | [`initial`], [`mapping`], [`orientation`], [`yaw`] |
//! | J^T W J, latents and offsets eliminated inside their own object | [`linear`] |
//! | argmax | [`solve`] |
//! | marginal covariances | [`covariance`] |
//! | the answer | [`posterior`], [`mod@estimate`] |
//! | argmax and marginals after every step | [`online`], [`incremental`] |
//! | which object was seen | [`association`] |
//! | which tracklets are of one object: one file an associator | [`mod@associator`] |
//! | what is refused, and settings | [`input`], [`settings`] |
//!
//! The world frame is that of the robot's first pose, whose z axis points up. Tangents are rotation first,
//! perturbations on the right (`T * Exp(xi)`). No ground truth comes in: the input is
//! [`vantage_dataset::Observations`].

pub mod association;
pub mod associator;
pub mod bearing_offset;
pub mod covariance;
pub mod discrepancy;
pub mod domain;
pub mod draws;
pub mod estimate;
pub mod estimator;
pub mod extents;
pub mod factor;
pub mod graph;
pub mod incremental;
pub mod initial;
pub mod input;
pub mod laplace;
pub mod lesson;
pub mod linear;
pub mod mapping;
pub mod noise;
pub mod noisy_first;
pub mod odometry_bias;
pub mod online;
pub mod orientation;
pub mod pairing;
mod plausible;
pub mod posterior;
pub mod problem;
pub mod se3_jacobian;
pub mod semantics;
pub mod set_down;
pub mod settings;
pub mod sighting;
pub mod solve;
pub mod unknown_object;
pub mod variable;
pub mod yaw;

pub use associator::{Association, Associator, Separate, WeightedPartition};
pub use domain::DomainPrior;
pub use estimate::{
    Dropped, Estimate, LandmarkEstimate, ObjectEstimate, Orientation, Unresolved, UnresolvedLandmark,
    UnresolvedReason,
};
pub use estimator::{
    AzimuthHead, Checked, DecoderAdapted, DecoderChecked, DecoderTaught, DiscreteClass, DomainAdapted,
    Estimator, Geometric, Learner, Learnt, OdometryOnly, PROCESS_SIZES, ProcessRefitted, Refitted, SeenView,
    Semantic, Uninformative, ViewpointPairs,
};
pub use input::EstimateError;
pub use lesson::{Lesson, PROCESSES};
pub use online::{Online, StepObservations};
pub use pairing::Pairing;
pub use settings::{
    AzimuthDiscrepancy, ExtentsSettings, GeometrySettings, LayerSettings, OdometrySettings,
    OrientationSettings, SemanticSettings, Settings, SolverSettings,
};
pub use solve::Outcome;
pub use variable::Key;
