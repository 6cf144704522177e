//! What the images of an arrangement show of its objects.

use super::DetectionLimits;
use super::arrangement::Arrangement;
use super::files::{CAMERA, Frame, Key};
use super::images::{ENDINGS, FOLDERS};
use super::masks::{Silhouettes, Visible, visible};
use super::mesh::ReadModel;
use crate::import::ImportReport;
use crate::picture::{read_jpeg, read_png};
use crate::principal_point;
use image::RgbImage;
use nalgebra::Vector2;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vantage_dataset::window::{Labelled, Window, cut};
use vantage_dataset::{BoundingBox, Camera, Detection, Mask};

/// What reads them.
pub(super) struct Sights<'a> {
    pub(super) scene: &'a Path,
    pub(super) models: &'a BTreeMap<u32, ReadModel>,
    pub(super) limits: &'a DetectionLimits,
    pub(super) silhouettes: &'a mut dyn Silhouettes,
    pub(super) report: &'a mut ImportReport,
    /// Detections below the limits, so far.
    pub(super) faint: usize,
}

/// Detections by step: the frames that could be read, and what each shows.
#[derive(Default)]
pub(super) struct Seen {
    /// That of the first of them; boxes in images of others are as it would have had them.
    pub(super) camera: Option<Camera>,
    /// Of each step, the number of its frame.
    pub(super) frames: Vec<usize>,
    pub(super) detections: Vec<Detection>,
    pub(super) visible_fractions: Vec<f64>,
}

impl Sights<'_> {
    pub(super) fn see(&mut self, arrangement: &Arrangement<'_>, tracks: &[Key]) -> Seen {
        let mut seen = Seen::default();
        for (number, frame) in arrangement.frames.iter().enumerate() {
            let Some(image) = self.image(frame) else { continue };
            let [fx, fy, cx, cy] = frame.intrinsics;
            let own = Camera { width: image.width(), height: image.height(), fx, fy, cx, cy };
            if !principal_point::is_inside(&own) {
                let what =
                    format!("image {}: cam_K has its principal point at {cx}, {cy}, outside of", frame.image);
                let what = format!("{what} {} x {} pixels", own.width, own.height);
                self.report.skip(self.scene.join(CAMERA), what);
                continue;
            }
            let visible = match visible(self.scene, frame, &own, self.models, self.silhouettes) {
                Ok(visible) => visible,
                Err(error) => {
                    self.report.skip(self.scene, error);
                    continue;
                }
            };
            let camera = *seen.camera.get_or_insert(own);
            let step = seen.frames.len();
            seen.frames.push(number);
            for (track, key) in tracks.iter().enumerate() {
                let found = self.detection(frame, *key, &image, &visible);
                let Some((detection, fraction)) = found else { continue };
                let bounding_box = as_seen_by(&camera, &own, &detection.bounding_box);
                seen.detections.push(Detection { step, track, bounding_box, ..detection });
                seen.visible_fractions.push(fraction);
            }
        }
        seen
    }

    fn image(&mut self, frame: &Frame) -> Option<RgbImage> {
        let name = |ending: &str| format!("{:06}.{ending}", frame.image);
        let places = FOLDERS
            .iter()
            .flat_map(|folder| ENDINGS.map(|ending| self.scene.join(folder).join(name(ending))));
        let Some(path) = places.into_iter().find(|path| path.is_file()) else {
            let path: PathBuf = self.scene.join(FOLDERS[0]).join(name(ENDINGS[0]));
            self.report.skip(path, "no image: PNG or JPEG in rgb or gray");
            return None;
        };
        let is_png = path.extension().is_some_and(|ending| ending == ENDINGS[0]);
        let read = if is_png { read_png(&path) } else { read_jpeg(&path) };
        read.map_err(|error| self.report.skip(path, error)).ok()
    }

    /// Its step and track are yet to be told.
    fn detection(
        &mut self,
        frame: &Frame,
        key: Key,
        image: &RgbImage,
        visible: &Visible,
    ) -> Option<(Detection, f64)> {
        let place = frame.objects.iter().position(|object| object.key == key)?;
        let fraction = visible.fractions[place]?;
        let id = frame.objects[place].index as u32 + 1;
        let width = image.width() as usize;
        let mask = Mask::of(&visible.ids, width, id)?;
        if fraction < self.limits.min_visible_fraction || mask.pixels < self.limits.min_mask_pixels {
            self.faint += 1;
            return None;
        }
        let labelled = Labelled { width, rgb: image.as_raw(), ids: &visible.ids };
        let window = Window::around(&mask.bounding_box);
        let detection = Detection {
            step: 0,
            track: 0,
            bounding_box: mask.bounding_box,
            mask_pixels: mask.pixels,
            center_depth: None,
            masked_crop: cut(&labelled, &window, Some(id)),
            boxed_crop: cut(&labelled, &window, None),
        };
        Some((detection, fraction))
    }
}

fn as_seen_by(camera: &Camera, own: &Camera, seen: &BoundingBox) -> BoundingBox {
    let moved = |pixel: &Vector2<f64>| {
        let ray = own.ray_in_camera(pixel);
        Vector2::new(camera.fx * ray.x / ray.z + camera.cx, camera.fy * ray.y / ray.z + camera.cy)
    };
    if camera == own { *seen } else { BoundingBox { min: moved(&seen.min), max: moved(&seen.max) } }
}
