//! What an observation model is, said once for those who train one and those who estimate by one.
//!
//! ```text
//! p(m(z) | e, x_rel)  =  t_nu(m(z); h(e, x_rel), (W^T W)^-1)      Eq. 10, in the reduced measurement of IV-C
//! P(e | z_1..z_n, x_1..x_n)  is proportional to  N(e; 0, I) prod_k q(e | z_k, x_k)                  Eq. 12
//! ```
//!
//! | symbol | here |
//! |---|---|
//! | `z` | [`Crop`](vantage_dataset::Crop) |
//! | `x_rel` | [`Viewpoint`](vantage_dataset::Viewpoint) |
//! | `m(z)`, `h(e, x_rel)`, `q(e \| z, x_rel)` | [`ObservationModel`] |
//! | `p(m(z) \| c, x_rel)` of Eq. 8 | [`ClassModel`] |
//! | `p(m(z') \| z, e, Delta X)` of Eq. 15 | [`PairModel`], [`PairLinearization`] |
//! | `h = W phi`, of which `W` may be learnt | [`LastLayer`] |
//! | an azimuth read off `z` alone | [`AzimuthSensor`] |
//! | numbers by which crops are compared | [`Embedding`] |
//! | `N(e; mean, variance)`, and products of them | [`LatentGaussian`], [`Information`] |
//! | derivatives of `h` to `e` and to the camera's pose | [`Linearization`], [`ViewpointDerivative`] |
//! | `W`, `nu` | [`MeasurementNoise`] |
//! | `t_nu` | [`student_t`] |
//! | smooth functions of an azimuth | [`Periodic`] |
//!
//! M numbers are measured, D are latent. Tangents are rotation first and perturb on the right: `T * Exp(xi)`.

mod azimuth_sensor;
mod class_model;
mod embedding;
mod error;
mod last_layer;
mod latent_gaussian;
pub mod linearization;
mod measurement_noise;
mod observation_model;
mod pair_model;
pub mod periodic;
pub mod student_t;

pub use azimuth_sensor::{AzimuthReading, AzimuthSensor};
pub use class_model::ClassModel;
pub use embedding::Embedding;
pub use error::AnswerError;
pub use last_layer::LastLayer;
pub use latent_gaussian::{Information, LatentGaussian};
pub use linearization::{Linearization, ViewpointDerivative};
pub use measurement_noise::MeasurementNoise;
pub use observation_model::ObservationModel;
pub use pair_model::{FirstView, PairLinearization, PairModel};
pub use periodic::Periodic;
