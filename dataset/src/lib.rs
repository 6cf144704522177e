//! The shared record of Vantage: what a robot observed, and what was true.
//!
//! An [`Episode`] splits by type into [`Observations`] (odometry `U`, geometric and semantic measurements
//! `Z^g`, `Z^s` of Eq. 1) and [`Truth`]. The estimator's crate takes [`Observations`] only, so that ground
//! truth cannot reach an estimate.
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
pub mod layout;
pub mod mask;
pub mod memory;
pub mod sample;
pub mod se3;
pub mod seed;
pub mod sighting;
pub mod store;
pub mod viewpoint;
pub mod views;
pub mod widest;
pub mod window;

pub use camera::Camera;
pub use capture::{Capture, CapturedObject};
pub use crop::Crop;
pub use episode::{
    BoundingBox, Detection, DetectionTruth, Episode, Extents, LandmarkSighting, ObjectTruth, Observations,
    Odometry, Truth,
};
pub use episode_views::episode_views;
pub use instance::{InstanceId, Split, Symmetry};
pub use mask::Mask;
pub use sample::Sample;
pub use se3::{Pose, Tangent};
pub use seed::{Seed, Stream};
pub use sighting::Sighting;
pub use viewpoint::Viewpoint;
pub use views::{View, ViewSet};
