//! Learned, viewpoint-dependent observation models: `p(z | e, x_rel)` of Eq. 10, fitted by Eq. 12-14 and reduced
//! to a few numbers as in IV-C.
//!
//! ```text
//! log p(z_k, beta_k | x_k) >= -KL(q(e | z_k, x_k) || N(0, I)) + E_q log p(z_k | e, x_k) + E_q log N(e; mu_beta, s^2 I)
//! ```
//!
//! | symbol | here |
//! |---|---|
//! | `z` | [`Crop`](vantage_dataset::Crop) |
//! | `x_rel` | [`Viewpoint`](vantage_dataset::Viewpoint), as the numbers of its conditioning |
//! | `e` | a vector of [`LatentLayout`]; its pairs turn with the azimuth |
//! | `q(e \| z, x)` | [`ViewpointModel::encode`], combined by [`LatentGaussian::posterior`] |
//! | `p(z \| e, x)` | [`ViewpointModel::predict`], [`ViewpointModel::linearize`], [`ViewpointModel::reconstruct`] |
//! | `m(z)` of IV-C | [`ViewpointModel::measure`], with [`ResidualNoise`] |
//!
//! A model is a folder of ONNX graphs with a manifest. The `train` feature (on by default) writes such folders with
//! burn; reading and running them needs tract alone.

mod architecture;
mod canary;
mod error;
mod latent;
mod manifest;
mod model;
mod onnx;
mod residual;
mod spec;
#[cfg(feature = "train")]
mod train;

pub use architecture::{Architecture, Convention};
pub use canary::{CANARY, Canary, CanaryCase};
pub use error::{GraphError, ModelError};
pub use latent::{LatentGaussian, LatentLayout};
pub use manifest::{FileRecord, GraphRecord, MANIFEST, Manifest, Role, TrainingRecord};
pub use model::{LARGEST_FILE, Linearization, ViewpointModel};
pub use onnx::{OPERATORS, OPSET, Signature, TensorSpec};
pub use residual::ResidualNoise;
pub use spec::{ClassSpec, Motion, Objective, Pairs, PredictiveSpec, TrainingSpec};
#[cfg(feature = "train")]
pub use train::{
    CHECKPOINT, CURVE_PICTURE, CURVE_TABLE, Progress, SHEET, Stage, TrainError, Training, train,
    view_set_hash,
};
