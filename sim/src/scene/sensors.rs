//! `sensors`: camera, detector and odometry.

use crate::render::MAX_SIDE;
use crate::scene::rule::not_nan;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Camera;

/// What the robot measures with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct SensorSpec {
    /// The camera.
    #[garde(dive)]
    pub camera: CameraSpec,
    /// The object detector.
    #[garde(dive)]
    pub detector: DetectorSpec,
    /// The odometry.
    #[garde(dive)]
    pub odometry: OdometrySpec,
}

/// A pinhole camera with square pixels and a centred principal point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// Width of the image, pixels.
    #[garde(range(min = 32, max = MAX_SIDE))]
    pub width: u32,
    /// Height of the image, pixels.
    #[garde(range(min = 32, max = MAX_SIDE))]
    pub height: u32,
    /// Horizontal field of view, degrees.
    #[garde(range(min = 10.0, max = 120.0), custom(not_nan))]
    pub horizontal_fov_deg: f64,
}

impl CameraSpec {
    /// Its intrinsics.
    pub fn intrinsics(&self) -> Camera {
        Camera::with_horizontal_fov(self.width, self.height, self.horizontal_fov_deg.to_radians())
    }
}

/// Which objects a detector reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct DetectorSpec {
    /// Least visible share of an object's silhouette; the part beyond the image's border is hidden.
    #[garde(range(min = 0.05, max = 1.0), custom(not_nan))]
    pub min_visible_fraction: f64,
    /// Least number of visible pixels.
    #[garde(range(min = 4))]
    pub min_mask_pixels: u32,
}

/// Noise of the odometry: standard deviations that grow with the motion between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct OdometrySpec {
    /// Of the translation, metres per metre travelled.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub translation_per_metre: f64,
    /// Of the rotation, degrees per metre travelled.
    #[garde(range(min = 0.0, max = 90.0), custom(not_nan))]
    pub rotation_deg_per_metre: f64,
    /// Of the rotation, radians per radian turned.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub rotation_per_radian: f64,
    /// Roll, pitch and height get this share of the noise of yaw and the horizontal plane.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub out_of_plane: f64,
    /// Of a translation error that stays the same in an episode, metres per metre travelled.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub bias_translation_per_metre: f64,
    /// Of a yaw error that stays the same in an episode, degrees per metre travelled.
    #[garde(range(min = 0.0, max = 90.0), custom(not_nan))]
    pub bias_rotation_deg_per_metre: f64,
}
