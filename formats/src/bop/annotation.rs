//! What BOP records of an image: camera, poses, boxes and masks.

use super::{DEPTH_SCALE, MILLIMETRES, Scene};
use crate::rle::Rle;
use serde::Serialize;
use serde_json::{Value, json};
use vantage_dataset::store::Fault;
use vantage_dataset::{Camera, Capture, CapturedObject, Pose};

/// Objects that are seen less than this are not counted in BOP's detection scores.
const IGNORED_BELOW: f64 = 0.1;

/// Entry of `scene_camera.json`.
#[derive(Serialize)]
pub(super) struct ImageCamera {
    #[serde(rename = "cam_K")]
    k: [f64; 9],
    #[serde(rename = "cam_R_w2c")]
    rotation: [f64; 9],
    #[serde(rename = "cam_t_w2c")]
    translation: [f64; 3],
    depth_scale: f64,
}

/// Entry of `scene_gt.json`.
#[derive(Serialize)]
pub(super) struct ObjectPose {
    pub(super) obj_id: u32,
    #[serde(rename = "cam_R_m2c")]
    rotation: [f64; 9],
    #[serde(rename = "cam_t_m2c")]
    translation: [f64; 3],
}

/// Entry of `scene_gt_info.json`. Boxes reach from the first pixel to the last: `x, y, last x - x, last y - y`.
#[derive(Serialize)]
pub(super) struct ObjectInfo {
    bbox_obj: [i64; 4],
    bbox_visib: [i64; 4],
    px_count_all: u64,
    px_count_valid: u64,
    px_count_visib: u64,
    pub(super) visib_fract: f64,
}

/// An image in BOP's terms; the masks are row-major.
pub(super) struct Annotation<'a> {
    pub(super) camera: ImageCamera,
    pub(super) poses: Vec<ObjectPose>,
    pub(super) infos: Vec<ObjectInfo>,
    pub(super) masks: Vec<&'a [bool]>,
    pub(super) visible_masks: Vec<Vec<bool>>,
    /// Of [`DEPTH_SCALE`] millimetres, 0 where nothing was drawn or it is too far to tell.
    pub(super) depth: Vec<u16>,
}

/// Row-major intrinsics with pixel centres at whole numbers, as BOP and OpenCV have them: half a pixel less than ours.
fn intrinsics(camera: &Camera) -> [f64; 9] {
    [camera.fx, 0.0, camera.cx - 0.5, 0.0, camera.fy, camera.cy - 0.5, 0.0, 0.0, 1.0]
}

/// `camera.json`.
pub(super) fn camera_file(camera: &Camera) -> Value {
    let k = intrinsics(camera);
    json!({
        "cx": k[2], "cy": k[5], "fx": k[0], "fy": k[4],
        "width": camera.width, "height": camera.height, "depth_scale": DEPTH_SCALE,
    })
}

impl<'a> Annotation<'a> {
    /// # Errors
    /// Where the capture contradicts itself, or names objects that the scene has not.
    pub(super) fn new(scene: &Scene<'_>, place: &str, capture: &'a Capture) -> Result<Self, Fault> {
        check(place, capture)?;
        let (rotation, translation) = matrix(&capture.world_from_camera.inverse());
        let k = intrinsics(&capture.camera);
        let mut annotation = Self {
            camera: ImageCamera { k, rotation, translation, depth_scale: DEPTH_SCALE },
            poses: Vec::new(),
            infos: Vec::new(),
            masks: Vec::new(),
            visible_masks: Vec::new(),
            depth: capture.depth.iter().map(|&metres| depth_value(metres)).collect(),
        };
        for object in &capture.objects {
            annotation.add(scene, place, capture, object)?;
        }
        Ok(annotation)
    }

    fn add(
        &mut self,
        scene: &Scene<'_>,
        place: &str,
        capture: &Capture,
        object: &'a CapturedObject,
    ) -> Result<(), Fault> {
        let track = object.track;
        let none = |got: String, expected: &str| Fault::new(place, None, "objects", got, expected);
        let truth = scene.objects.get(track);
        let truth = truth.ok_or_else(|| none(format!("track {track}"), "a track of the scene's objects"))?;
        let obj_id = scene.ids.get(&truth.instance);
        let obj_id = *obj_id.ok_or_else(|| none(truth.instance.to_string(), "an instance with an obj_id"))?;

        let id = track as u32 + 1;
        let visible: Vec<bool> = capture.ids.iter().map(|&pixel| pixel == id).collect();
        let visible_pixels = count(&visible);
        let consistent = visible_pixels == u64::from(object.visible_pixels)
            && visible_pixels > 0
            && object.silhouette.len() == visible.len();
        if !consistent {
            let got =
                format!("{visible_pixels} pixels of id {id}, {} of silhouette", object.silhouette.len());
            let expected = format!("{} pixels, of {}", object.visible_pixels.max(1), visible.len());
            return Err(Fault::new(place, None, format!("objects, track {track}"), got, expected));
        }
        let all =
            (object.silhouette_pixels.round() as u64).max(count(&object.silhouette)).max(visible_pixels);
        let has_depth =
            object.silhouette.iter().zip(&self.depth).filter(|&(&in_it, &depth)| in_it && depth > 0);
        let visible_box = pixel_box(&visible, capture.camera.width).unwrap_or([0; 4]);
        let silhouette = &object.silhouette_box;
        let (left, top) = (silhouette.min.x.floor() as i64, silhouette.min.y.floor() as i64);
        let (right, bottom) = (silhouette.max.x.ceil() as i64 - 1, silhouette.max.y.ceil() as i64 - 1);

        let (rotation, translation) =
            matrix(&(capture.world_from_camera.inverse() * truth.world_from_object));
        self.poses.push(ObjectPose { obj_id, rotation, translation });
        self.infos.push(ObjectInfo {
            bbox_obj: [left, top, right - left, bottom - top],
            bbox_visib: visible_box,
            px_count_all: all,
            px_count_valid: has_depth.count() as u64,
            px_count_visib: visible_pixels,
            visib_fract: visible_pixels as f64 / all as f64,
        });
        self.masks.push(&object.silhouette);
        self.visible_masks.push(visible);
        Ok(())
    }

    /// The image's objects for `scene_gt_coco.json`, numbered from `first`. Boxes are those of the whole mask, and count
    /// pixels.
    pub(super) fn coco(&self, image: u32, first: usize, width: u32, height: u32) -> Vec<Value> {
        let entry = |i: usize| {
            let (mask, visible) = (self.masks[i], &self.visible_masks[i]);
            let whole = pixel_box(mask, width).or_else(|| pixel_box(visible, width));
            let [x, y, w, h] = whole.unwrap_or([0; 4]);
            json!({
                "id": first + i,
                "image_id": image,
                "category_id": self.poses[i].obj_id,
                "iscrowd": 0,
                "area": count(visible),
                "bbox": [x, y, w + 1, h + 1],
                "segmentation": Rle::encode(visible, width as usize),
                "width": width,
                "height": height,
                "ignore": self.infos[i].visib_fract < IGNORED_BELOW,
            })
        };
        (0..self.poses.len()).map(entry).collect()
    }
}

fn check(place: &str, capture: &Capture) -> Result<(), Fault> {
    let camera = &capture.camera;
    let pixels = u64::from(camera.width) * u64::from(camera.height);
    let lengths = [
        ("rgb", capture.rgb.len(), 3 * pixels),
        ("depth", capture.depth.len(), pixels),
        ("ids", capture.ids.len(), pixels),
    ];
    for (field, got, expected) in lengths {
        if got as u64 != expected || expected == 0 {
            return Err(Fault::new(place, None, field, got, format!("{expected} values, more than none")));
        }
    }
    let pose = &capture.world_from_camera;
    let numbers = pose.translation.vector.iter().chain(&pose.rotation.coords);
    match numbers.chain([&camera.fx, &camera.fy, &camera.cx, &camera.cy]).find(|number| !number.is_finite()) {
        Some(stray) => Err(Fault::new(place, None, "camera", stray, "finite numbers")),
        None => Ok(()),
    }
}

fn depth_value(metres: f32) -> u16 {
    let value = (f64::from(metres) * MILLIMETRES / DEPTH_SCALE).round();
    if (0.0..=f64::from(u16::MAX)).contains(&value) { value as u16 } else { 0 }
}

/// Rotation, row-major, and translation in millimetres.
fn matrix(pose: &Pose) -> ([f64; 9], [f64; 3]) {
    let mut rows = [0.0; 9];
    rows.copy_from_slice(pose.rotation.to_rotation_matrix().matrix().transpose().as_slice());
    (rows, (pose.translation.vector * MILLIMETRES).into())
}

fn count(mask: &[bool]) -> u64 {
    mask.iter().filter(|&&set| set).count() as u64
}

/// `x, y, last x - x, last y - y` of a mask's pixels.
fn pixel_box(mask: &[bool], width: u32) -> Option<[i64; 4]> {
    let width = width as usize;
    let set = || mask.iter().enumerate().filter(|&(_, &set)| set).map(|(i, _)| (i % width, i / width));
    let (left, right) = (set().map(|p| p.0).min()?, set().map(|p| p.0).max()?);
    let (top, bottom) = (set().map(|p| p.1).min()?, set().map(|p| p.1).max()?);
    Some([left, top, right - left, bottom - top].map(|value| value as i64))
}
