//! Detections and landmarks as the graph uses them: rays with an angular size by track, pixels by landmark.

use nalgebra::Vector3;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use vantage_dataset::{BoundingBox, Camera, CenterDepth, Detection, LandmarkSighting, Observations};

/// A detection whose box is whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Index into [`Observations::detections`].
    pub detection: usize,
    /// Step at which it was seen.
    pub step: usize,
    /// Ray through the box centre, camera frame, `z = 1`.
    pub ray_in_camera: Vector3<f64>,
    /// Longer side of the box over the focal length.
    pub angular_size: f64,
    /// Left, top, right and bottom of the box as rays `(x / z, y / z)`, camera frame.
    pub edges: [f64; 4],
    /// How far off the object's centre is, where the detector tells.
    pub depth: Option<CenterDepth>,
}

/// All whole detections by track and step, and the number of truncated ones by track.
///
/// The order does not depend on the order of the detections.
pub fn sightings(observations: &Observations) -> (BTreeMap<usize, Vec<Sighting>>, BTreeMap<usize, usize>) {
    let mut order: Vec<usize> = (0..observations.detections.len()).collect();
    order.sort_by(|&a, &b| compare(&observations.detections[a], &observations.detections[b]));
    let camera = observations.camera;
    let mut whole: BTreeMap<usize, Vec<Sighting>> = BTreeMap::new();
    let mut truncated = BTreeMap::new();
    for index in order {
        let detection = &observations.detections[index];
        match Sighting::new(&camera, index, detection) {
            Some(sighting) => whole.entry(detection.track).or_default().push(sighting),
            None => *truncated.entry(detection.track).or_insert(0) += 1,
        }
    }
    (whole, truncated)
}

impl Sighting {
    /// The detection of this index, or `None` where it is truncated.
    pub fn new(camera: &Camera, index: usize, detection: &Detection) -> Option<Self> {
        let bounds = &detection.bounding_box;
        (!bounds.is_truncated(camera)).then(|| Self {
            detection: index,
            step: detection.step,
            ray_in_camera: camera.ray_in_camera(&bounds.center()),
            angular_size: bounds.side() / camera.focal_length(),
            edges: edges(camera, bounds),
            depth: detection.center_depth,
        })
    }
}

fn edges(camera: &Camera, bounds: &BoundingBox) -> [f64; 4] {
    let (least, greatest) = (camera.ray_in_camera(&bounds.min), camera.ray_in_camera(&bounds.max));
    [least.x, least.y, greatest.x, greatest.y]
}

/// All sightings of landmarks by landmark and step.
///
/// The order does not depend on the order of the sightings.
pub fn landmark_sightings(observations: &Observations) -> BTreeMap<usize, Vec<LandmarkSighting>> {
    let mut sorted = observations.landmarks.clone();
    let numbers = |s: &LandmarkSighting| [s.pixel.x, s.pixel.y, s.sigma];
    sorted.sort_by(|a, b| {
        let differ = numbers(a).iter().zip(numbers(b)).map(|(x, y)| x.total_cmp(&y)).find(|o| o.is_ne());
        a.step.cmp(&b.step).then(differ.unwrap_or(Ordering::Equal))
    });
    let mut of: BTreeMap<usize, Vec<LandmarkSighting>> = BTreeMap::new();
    for sighting in sorted {
        of.entry(sighting.landmark).or_default().push(sighting);
    }
    of
}

fn compare(a: &Detection, b: &Detection) -> Ordering {
    let numbers = |d: &Detection| {
        let bounds = d.bounding_box;
        let depth = d.center_depth.map_or([0.0; 2], |depth| [depth.meters, depth.sigma]);
        [bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y, depth[0], depth[1]]
    };
    (a.track, a.step)
        .cmp(&(b.track, b.step))
        .then_with(|| {
            numbers(a)
                .iter()
                .zip(numbers(b))
                .map(|(x, y)| x.total_cmp(&y))
                .find(|ordering| ordering.is_ne())
                .unwrap_or(Ordering::Equal)
        })
        .then_with(|| a.masked_crop.0.cmp(&b.masked_crop.0))
}
