//! Labelled crops, one by one: what crop formats for training are written from.

use crate::camera::Camera;
use crate::crop::Crop;
use crate::episode::{BoundingBox, Episode};
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
    /// Seconds since the episode's start.
    pub timestamp: f64,
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
    /// Intrinsics of the image that the box is in.
    pub camera: Camera,
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

impl Episode {
    /// The detections of objects with their labels, in order; those of nothing are left out.
    pub fn samples(&self, split: Split) -> impl Iterator<Item = Sample> + '_ {
        let (observed, truth) = (&self.observations, &self.truth);
        let detections = observed.detections.iter().zip(&truth.detections).enumerate();
        detections.filter_map(move |(number, (detection, seen))| {
            let object = truth.shown(number, detection)?;
            let world_from_camera = truth.world_from_robot[detection.step] * observed.robot_from_camera;
            let object_from_camera = object.world_from_object.inv_mul(&world_from_camera);
            Some(Sample {
                episode: self.seed.0,
                step: detection.step,
                timestamp: observed.timestamps[detection.step],
                track: detection.track,
                instance: object.instance,
                family: object.family.clone(),
                split,
                bounding_box: detection.bounding_box,
                visible_fraction: seen.visible_fraction,
                camera: observed.camera,
                world_from_camera,
                object_from_camera,
                viewpoint: Viewpoint::new(&object_from_camera, object.size),
                masked_crop: detection.masked_crop.clone(),
                boxed_crop: detection.boxed_crop.clone(),
            })
        })
    }
}
