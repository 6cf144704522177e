//! `sensors`: camera, detector and odometry.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Camera;
use vantage_dataset::rule::not_nan;

/// Greatest width and height of an image, pixels.
pub const MAX_SIDE: u32 = 4096;

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
    /// Point landmarks on floor, walls and furniture; none where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub landmarks: Option<LandmarkSpec>,
}

/// A pinhole camera: `horizontal_fov_deg` of one with square pixels and a centred principal point, or the `intrinsics` of any.
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
    #[schemars(range(min = 10.0, max = 120.0))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(inner(range(min = 10.0, max = 120.0), custom(not_nan)), custom(either_this_or(self.intrinsics.is_some())))]
    pub horizontal_fov_deg: Option<f64>,
    /// Focal lengths and principal point, in its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive, custom(fits(self.width, self.height)))]
    pub intrinsics: Option<IntrinsicsSpec>,
    /// What it does to images; perfect where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub image: Option<ImageSpec>,
}

/// A pinhole camera as calibrations have it, pixels; the middle of the upper left pixel is at (0.5, 0.5).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct IntrinsicsSpec {
    /// Focal length along x.
    #[garde(range(min = 10.0, max = 20_000.0), custom(not_nan))]
    pub fx: f64,
    /// Focal length along y.
    #[garde(range(min = 10.0, max = 20_000.0), custom(not_nan))]
    pub fy: f64,
    /// Principal point, x.
    #[garde(range(min = 0.0, max = f64::from(MAX_SIDE)), custom(not_nan))]
    pub cx: f64,
    /// Principal point, y.
    #[garde(range(min = 0.0, max = f64::from(MAX_SIDE)), custom(not_nan))]
    pub cy: f64,
}

fn either_this_or(other: bool) -> impl FnOnce(&Option<f64>, &()) -> garde::Result {
    move |this, ()| {
        let message = "set either horizontal_fov_deg or intrinsics";
        if this.is_some() == other { Err(garde::Error::new(message)) } else { Ok(()) }
    }
}

/// Holds a camera to fields of view that `horizontal_fov_deg` may have, and its principal point to the image.
fn fits(width: u32, height: u32) -> impl FnOnce(&Option<IntrinsicsSpec>, &()) -> garde::Result {
    move |intrinsics, ()| {
        let Some(IntrinsicsSpec { fx, fy, cx, cy }) = intrinsics else { return Ok(()) };
        for (side, focal_length, center, of) in [(width, fx, cx, "x"), (height, fy, cy, "y")] {
            let side = f64::from(side);
            let degrees = 2.0 * libm::atan(side / 2.0 / focal_length).to_degrees();
            if !(5.0..=120.0).contains(&degrees) {
                return Err(garde::Error::new(format!(
                    "f{of} gives {degrees:.1} degrees, expected 5 to 120"
                )));
            }
            if *center > side {
                return Err(garde::Error::new(format!(
                    "c{of} is {center}, beyond the image's {side} pixels"
                )));
            }
        }
        Ok(())
    }
}

/// Imperfections of a camera's images, drawn anew for each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct ImageSpec {
    /// Standard deviation of the exposure, stops: factors of two of the light.
    #[serde(default)]
    #[garde(range(min = 0.0, max = 4.0), custom(not_nan))]
    pub exposure_stops: f64,
    /// Standard deviation of the Gaussian that blurs, pixels.
    #[serde(default)]
    #[garde(range(min = 0.0, max = 20.0), custom(not_nan))]
    pub blur_pixels: f64,
    /// Standard deviation of the noise in each channel of each pixel, of 255 levels.
    #[serde(default)]
    #[garde(range(min = 0.0, max = 100.0), custom(not_nan))]
    pub noise_levels: f64,
}

impl CameraSpec {
    /// Its intrinsics.
    pub fn intrinsics(&self) -> Camera {
        let Self { width, height, .. } = *self;
        match (&self.intrinsics, self.horizontal_fov_deg) {
            (Some(IntrinsicsSpec { fx, fy, cx, cy }), _) => {
                Camera { width, height, fx: *fx, fy: *fy, cx: *cx, cy: *cy }
            }
            (None, degrees) => {
                Camera::with_horizontal_fov(width, height, degrees.unwrap_or_default().to_radians())
            }
        }
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
    /// What it gets wrong; nothing where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub faults: Option<DetectorFaultsSpec>,
    /// Standard deviation of the depth that it tells of an object's centre, along the optical axis, metres; it tells none where left
    /// out.
    #[schemars(range(min = 1e-4, max = 10.0))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(inner(range(min = 1e-4, max = 10.0), custom(not_nan)))]
    pub depth_sigma: Option<f64>,
}

/// Mistakes of a detector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct DetectorFaultsSpec {
    /// Standard deviation of a box's centre and of the logarithm of its sides, in units of its sides.
    #[serde(default)]
    #[garde(range(min = 0.0, max = 0.5), custom(not_nan))]
    pub box_jitter: f64,
    /// Share of detections that are missed.
    #[serde(default)]
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub miss_probability: f64,
    /// Mean number of detections of nothing in an image; each is a track of its own.
    #[serde(default)]
    #[garde(range(min = 0.0, max = 20.0), custom(not_nan))]
    pub false_per_image: f64,
    /// Share of them that get the track of an object that was seen before and is not detected in the image, as by a wrong association; in
    /// place of a track of their own.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub misassigned: f64,
}

fn is_zero(share: &f64) -> bool {
    *share <= 0.0
}

/// Point landmarks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct LandmarkSpec {
    /// How many the room has.
    #[garde(range(min = 1, max = 100_000))]
    pub count: u32,
    /// Standard deviation of a measured pixel, along each axis.
    #[garde(range(min = 0.01, max = 100.0), custom(not_nan))]
    pub pixel_sigma: f64,
    /// Greatest depth at which one is seen, metres.
    #[garde(range(min = 0.1, max = 1000.0), custom(not_nan))]
    pub max_range: f64,
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
    /// Wheels that slip: outliers that the covariance does not know of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub slip: Option<SlipSpec>,
}

/// Slipping wheels: at some steps the odometry reports more motion than there was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct SlipSpec {
    /// Share of steps at which they slip.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub probability: f64,
    /// Greatest excess, as a share of the distance travelled; drawn evenly from 0.
    #[garde(range(min = 0.0, max = 10.0), custom(not_nan))]
    pub excess: f64,
}
