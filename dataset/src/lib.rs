//! The shared record of Vantage: what a robot observed, and what was true.
//!
//! ```text
//! P(X, L, O, E | H),   H_k = { U_0 .. U_{k-1}, Z_0 .. Z_k },   Z_k = { Z^g_k, Z^s_k }      (Eq. 1, 6)
//! ```
//!
//! An [`Episode`] splits by type into [`Observations`], which is `H`, and [`Truth`], which is `X`, `L` and `O`. The
//! estimator's crate takes [`Observations`] only, so that ground truth cannot reach an estimate.
//!
//! | module | what it holds | equation |
//! |---|---|---|
//! | [`episode`] | odometry `U`, detections and landmarks `Z^g`, crops `Z^s`; the truth of each | 1 |
//! | [`camera`], [`crop`], [`mask`], [`window`] | pinhole camera; 32 x 32 crops and how they are cut | 6 |
//! | [`viewpoint`] | the allocentric viewpoint `x_rel` and its derivative | 10 |
//! | [`sighting`], [`ray`] | viewpoints by odometry and boxes alone; where lines of sight meet | 16-19 |
//! | [`instance`], [`views`], [`mod@episode_views`] | instances, their splits and symmetries; sets of views to train on | 12-14 |
//! | [`self_similarity`] | symmetries, measured | |
//! | [`tracklets`] | observations that do not tell which object a detection is of | |
//! | [`sample`], [`capture`] | labelled crops and whole images, for formats of others | |
//! | [`se3`], [`median`], [`rule`], [`seed`], [`widest`], [`jpeg`] | SE(3); medians; rules of settings; named random streams; vector instructions; whether a JPEG is whole | |
//! | [`store`] | episodes and view sets on disk; the cache of stages | |
//!
//! Units are SI and radians, `f64` for geometry and `u8`/`f32` for images. The world is z-up; cameras follow
//! OpenCV (x right, y down, z forward, pixel centres at +0.5). SE(3) tangents are rotation first, and
//! perturb on the right: `T * Exp(xi)`.

pub mod camera;
pub mod capture;
pub mod crop;
pub mod episode;
pub mod episode_views;
pub mod instance;
pub mod jpeg;
pub mod mask;
pub mod median;
pub mod ray;
pub mod rule;
pub mod sample;
pub mod se3;
pub mod seed;
pub mod self_similarity;
pub mod sighting;
pub mod store;
pub mod tracklets;
pub mod viewpoint;
pub mod views;
pub mod widest;
pub mod window;

pub use camera::Camera;
pub use capture::{Capture, CapturedObject};
pub use crop::Crop;
pub use episode::{
    BoundingBox, CenterDepth, Detection, DetectionTruth, Episode, Extents, LandmarkSighting, ObjectTruth,
    Observations, Odometry, Truth,
};
pub use episode_views::{episode_views, episodes_views};
pub use instance::{InstanceId, Split, Symmetry};
pub use mask::Mask;
pub use sample::Sample;
pub use se3::{Pose, Tangent};
pub use seed::{Seed, Stream};
pub use self_similarity::SelfSimilarity;
pub use sighting::Sighting;
pub use tracklets::Tracklets;
pub use viewpoint::Viewpoint;
pub use views::{View, ViewSet};
