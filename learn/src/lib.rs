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
//! | `q(e \| z, x)`, `p(m(z) \| e, x)`, `m(z)` of IV-C | [`ObservationModel`](vantage_model::ObservationModel) of [`ViewpointModel`] |
//! | the whole `z` expected of `e` and `x` | [`Viewing::reconstruct`] |
//! | the noise of `m(z)`, fitted | [`ResidualNoise`] |
//!
//! [`Model`] is any of three kinds, [`ViewpointModel`] the one of this table; [`PredictiveModel`] is that of Eq. 15-20, and
//! [`TurningModel`] such a one as an observation model.
//! Each is a folder of ONNX graphs with a manifest, ours or anyone's. The `train` feature (on by default) writes such folders with
//! burn; reading and running them needs tract alone.

mod architecture;
mod canary;
mod change;
mod derivatives;
mod difference;
mod embedding_model;
mod error;
mod file;
mod folder;
pub mod gaussian_process;
mod last_layer;
mod latent;
mod manifest;
mod model;
mod onnx;
mod periodic_fit;
mod predictive_model;
pub mod readout;
mod residual;
pub mod residual_process;
mod role;
mod spec;
#[cfg(feature = "train")]
mod train;
mod turning_model;
mod viewing;
mod viewpoint_model;

pub use architecture::Architecture;
pub use canary::{CANARY, Canary, CanaryCase};
pub use change::{camera_motion, object_centred_change};
pub use embedding_model::EmbeddingModel;
pub use error::{GraphError, ModelError, NodeFault};
pub use folder::LARGEST_FILE;
pub use last_layer::DecoderLastLayer;
pub use latent::{Latent, LatentLayout};
pub use manifest::{
    FORMAT, FileRecord, GraphRecord, MANIFEST, Manifest, TrainingDetails, TrainingRecord, VERSION,
};
pub use model::Model;
pub use onnx::{OPERATORS, OPSETS, Signature, TensorSpec};
pub use predictive_model::{PredictiveLinearization, PredictiveModel};
pub use residual::ResidualNoise;
pub use role::{Convention, Kind, Role, Sizes};
pub use spec::{
    ClassSpec, Frames, InstanceTerm, Motion, Objective, Pairs, PredictiveSpec, TrainingSpec, TrunkTarget,
};
#[cfg(feature = "train")]
pub use train::{
    CHECKPOINT, CURVE_PICTURE, CURVE_TABLE, INSTANCE_LIST, Progress, SHEET, Stage, TrainError, Training,
    TrainingDevice, train, view_set_hash,
};
pub use turning_model::TurningModel;
pub use viewing::Viewing;
pub use viewpoint_model::ViewpointModel;
