//! A scene's annotations: `scene_camera.json`, `scene_gt.json` and `scene_gt_info.json`.

use super::super::MILLIMETRES;
use super::places::GT;
use super::{images, json};
use crate::import::{ImportError, ImportReport};
use crate::rigid::nearly_rigid;
use nalgebra::{Matrix3, Vector2, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use vantage_dataset::{BoundingBox, Pose};

pub(super) const CAMERA: &str = "scene_camera.json";
const INFO: &str = "scene_gt_info.json";
const LARGEST_FILE: u64 = 1 << 28;
/// Focal lengths that a lens may have, pixels.
const FOCAL: Range<f64> = 1.0..1e6;
/// Metres, beyond which a pose is taken for one in another unit.
const FARTHEST: f64 = 1e4;

/// An object of the images: the `nth` of a model among those of one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    pub(super) object: u32,
    pub(super) nth: usize,
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.nth {
            0 => write!(f, "{}", self.object),
            nth => write!(f, "{} ({})", self.object, nth + 1),
        }
    }
}

/// An image's annotations.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) image: u32,
    /// `fx, fy, cx, cy`, pixel centres at halves.
    pub(super) intrinsics: [f64; 4],
    pub(super) world_from_camera: Option<Pose>,
    pub(super) objects: Vec<Annotated>,
}

/// An object in an image.
#[derive(Clone, Debug)]
pub(super) struct Annotated {
    /// Its place in the list, which its masks' names have.
    pub(super) index: usize,
    pub(super) key: Key,
    pub(super) camera_from_model: Pose,
    pub(super) visible_fraction: Option<f64>,
    pub(super) visible_box: Option<BoundingBox>,
}

#[derive(Deserialize)]
struct CameraEntry {
    #[serde(rename = "cam_K")]
    k: [f64; 9],
    #[serde(rename = "cam_R_w2c")]
    rotation: Option<[f64; 9]>,
    #[serde(rename = "cam_t_w2c")]
    translation: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct PoseEntry {
    obj_id: u32,
    #[serde(rename = "cam_R_m2c")]
    rotation: [f64; 9],
    #[serde(rename = "cam_t_m2c")]
    translation: [f64; 3],
}

#[derive(Deserialize)]
struct InfoEntry {
    bbox_visib: [f64; 4],
    visib_fract: f64,
}

/// The images of a scene in the order of their numbers, whose camera and objects are all known. What cannot be used is left out.
pub(super) fn read_frames(scene: &Path, report: &mut ImportReport) -> Result<Vec<Frame>, ImportError> {
    let cameras: BTreeMap<u32, CameraEntry> = read_json(scene, CAMERA)?;
    let poses: BTreeMap<u32, Vec<PoseEntry>> = read_json(scene, GT)?;
    let infos: Option<BTreeMap<u32, Vec<InfoEntry>>> = match read_json(scene, INFO) {
        Err(error) if error.is_absence() => None,
        other => Some(other?),
    };
    let files = images::numbers(scene);
    let unannotated: Vec<u32> = files.iter().copied().filter(|image| !poses.contains_key(image)).collect();
    let (mut frames, mut is_given) = (Vec::new(), false);
    for (image, poses) in poses {
        let leave_out = |report: &mut ImportReport, file, why: &str| {
            report.skip(scene.join(file), format!("image {image}: {why}"))
        };
        let Some(camera) = cameras.get(&image) else {
            leave_out(report, CAMERA, "no camera");
            continue;
        };
        let Some(intrinsics) = intrinsics(&camera.k) else {
            leave_out(
                report,
                CAMERA,
                "cam_K is no pinhole camera without skew, its focal length from 1 to 10^6 pixels",
            );
            continue;
        };
        let info = infos.as_ref().map(|infos| infos.get(&image).map_or(&[][..], Vec::as_slice));
        if info.is_some_and(|info| info.len() != poses.len()) {
            leave_out(report, INFO, "not one entry for each object");
            continue;
        }
        let camera_from_world = camera
            .rotation
            .zip(camera.translation)
            .and_then(|(rotation, translation)| pose(&rotation, &translation));
        is_given |= camera.rotation.is_some() || camera.translation.is_some();
        let world_from_camera = camera_from_world.map(|camera_from_world| camera_from_world.inverse());
        let mut frame = Frame { image, intrinsics, world_from_camera, objects: Vec::new() };
        let mut seen = BTreeMap::<u32, usize>::new();
        for (index, entry) in poses.iter().enumerate() {
            let nth = seen.entry(entry.obj_id).or_default();
            let key = Key { object: entry.obj_id, nth: *nth };
            *nth += 1;
            let Some(camera_from_model) = pose(&entry.rotation, &entry.translation) else {
                leave_out(report, GT, &format!("object {key} has no rigid pose in millimetres"));
                continue;
            };
            let info = info.map(|info| &info[index]);
            frame.objects.push(Annotated {
                index,
                key,
                camera_from_model,
                visible_fraction: info.map(|info| info.visib_fract.clamp(0.0, 1.0)).filter(|f| f.is_finite()),
                visible_box: info.and_then(|info| of_pixels(info.bbox_visib)),
            });
        }
        frames.push(frame);
    }
    if let Some(first) = unannotated.first() {
        let (those, all) = (unannotated.len(), files.len());
        report
            .skip(scene.join(GT), format!("{those} of {all} images, image {first} the first, have no entry"));
    }
    let without: Vec<u32> = frames
        .iter()
        .filter(|frame: &&Frame| frame.world_from_camera.is_none())
        .map(|frame| frame.image)
        .collect();
    if let (true, Some(first)) = (is_given, without.first()) {
        let (those, all) = (without.len(), frames.len());
        let what = format!(
            "{those} of {all} images, image {first} the first, have no rigid cam_R_w2c and cam_t_w2c"
        );
        report.skip(scene.join(CAMERA), format!("{what}: all cameras follow from objects"));
    }
    if frames.is_empty() {
        let why = report.skipped.iter().find(|skipped| skipped.file.starts_with(scene));
        let (file, got) = match why {
            Some(skipped) => (skipped.file.clone(), format!("none; {}", skipped.reason)),
            None => (scene.join(GT), "none".to_owned()),
        };
        let expected = "an image with its camera and objects";
        return Err(ImportError::invalid(&file, "images", got, expected, "mend the annotations"));
    }
    Ok(frames)
}

fn read_json<T: DeserializeOwned>(scene: &Path, name: &str) -> Result<BTreeMap<u32, T>, ImportError> {
    let expected = "an object of entries by the number of the image, as BOP has them";
    json::read(&scene.join(name), LARGEST_FILE, expected)
}

fn intrinsics(k: &[f64; 9]) -> Option<[f64; 4]> {
    let [fx, skew, cx, a, fy, cy, b, c, one] = *k;
    let is_pinhole = [skew, a, b, c].iter().all(|zero| zero.abs() < 1e-9) && (one - 1.0).abs() < 1e-9;
    let is_sound = FOCAL.contains(&fx) && FOCAL.contains(&fy) && cx.is_finite() && cy.is_finite();
    (is_pinhole && is_sound).then_some([fx, fy, cx + 0.5, cy + 0.5])
}

fn pose(rotation: &[f64; 9], millimetres: &[f64; 3]) -> Option<Pose> {
    let translation = Vector3::from(*millimetres) / MILLIMETRES;
    let is_near = translation.iter().all(|value| value.is_finite()) && translation.norm() < FARTHEST;
    if is_near { nearly_rigid(Matrix3::from_row_slice(rotation), translation) } else { None }
}

/// A box `x, y, last x - x, last y - y`; none where nothing is visible.
fn of_pixels([x, y, width, height]: [f64; 4]) -> Option<BoundingBox> {
    let is_box = [x, y, width, height].iter().all(|value| value.is_finite()) && width >= 0.0 && height >= 0.0;
    is_box.then(|| BoundingBox {
        min: Vector2::new(x, y),
        max: Vector2::new(x + width + 1.0, y + height + 1.0),
    })
}
