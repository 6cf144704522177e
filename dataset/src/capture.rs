//! Whole images with everything that is true of them, for formats that hold more than crops.

use crate::camera::Camera;
use crate::episode::BoundingBox;
use crate::se3::Pose;

/// One image.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// Seconds since the start of the episode.
    pub timestamp: f64,
    /// Intrinsics.
    pub camera: Camera,
    /// Where the camera was.
    pub world_from_camera: Pose,
    /// sRGB, row-major, interleaved: `3 * width * height` bytes.
    pub rgb: Vec<u8>,
    /// Metres along the optical axis, row-major; infinite where nothing was drawn.
    pub depth: Vec<f32>,
    /// Of each pixel, row-major: 0 for the surroundings, `track + 1` for an object.
    pub ids: Vec<u32>,
    /// The objects of which a pixel is visible, by track.
    pub objects: Vec<CapturedObject>,
}

/// One object in an image.
#[derive(Clone, Debug, PartialEq)]
pub struct CapturedObject {
    /// Its index among the episode's objects.
    pub track: usize,
    /// Box of its visible pixels.
    pub visible_box: BoundingBox,
    /// How many pixels of it are visible.
    pub visible_pixels: u32,
    /// Box of its whole silhouette, pixels; may lie partly outside of the image.
    pub silhouette_box: BoundingBox,
    /// Area of its whole silhouette, occluded parts and those outside of the image included, pixels.
    pub silhouette_pixels: f64,
    /// The part of the silhouette that lies in the image, occluded parts included: of each pixel, row-major.
    pub silhouette: Vec<bool>,
}
