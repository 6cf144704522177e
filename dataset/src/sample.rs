//! Labelled crops, one by one: what crop formats for training are written from.

use crate::crop::Crop;
use crate::episode::BoundingBox;
use crate::instance::{InstanceId, Split};
use crate::se3::Pose;
use crate::viewpoint::Viewpoint;

/// One crop with its labels.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The seed of its episode.
    pub episode: u64,
    /// Step of the episode.
    pub step: usize,
    /// Index of the object in its episode.
    pub track: usize,
    /// Which object.
    pub instance: InstanceId,
    /// Name of its family.
    pub family: String,
    /// The split that the object belongs to.
    pub split: Split,
    /// Box of the visible mask, pixels.
    pub bounding_box: BoundingBox,
    /// Visible share of the silhouette, in `[0, 1]`.
    pub visible_fraction: f64,
    /// Where the camera was.
    pub world_from_camera: Pose,
    /// The camera in the object's frame.
    pub object_from_camera: Pose,
    /// The allocentric viewpoint; none where it is undefined, as from straight above.
    pub viewpoint: Option<Viewpoint>,
    /// The crop with all but the object black.
    pub masked_crop: Crop,
    /// The crop with its surroundings.
    pub boxed_crop: Crop,
}
