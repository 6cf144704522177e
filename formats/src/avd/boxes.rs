//! Boxes of a scan as detections.

use super::annotations::LabelledBox;
use super::labels;
use super::name::{depth_of, image_file};
use super::objects::Evidence;
use crate::Lens;
use crate::import::ImportReport;
use crate::picture::{DepthImage, read_depth, read_jpeg};
use image::RgbImage;
use nalgebra::Vector2;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::median::median;
use vantage_dataset::window::{Labelled, Window, cut};
use vantage_dataset::{BoundingBox, Camera, Detection, Pose};

/// How much of a box, along each side, its depth is taken of.
const CORE: f64 = 0.3;
/// How much the shape of an image may differ from that of the camera's.
const SAME_SHAPE: f64 = 0.01;

/// A detection with what places its object. Its track is an index among the names that are present.
pub(super) struct Found {
    pub(super) detection: Detection,
    pub(super) evidence: Evidence,
}

/// One image with boxes.
struct Photo {
    step: usize,
    world_from_camera: Pose,
    image: RgbImage,
    /// One for each pixel: there are no masks.
    ids: Vec<u32>,
    /// Pixels of the image in one of the camera's.
    scale: Vector2<f64>,
    depth: Option<DepthImage>,
}

/// Reads the boxes of one image after the other.
pub(super) struct BoxReader<'a> {
    pub(super) folder: &'a Path,
    pub(super) camera: Camera,
    pub(super) lens: Lens,
    pub(super) names: &'a BTreeMap<u32, String>,
    pub(super) present: &'a [String],
    pub(super) report: ImportReport,
}

impl BoxReader<'_> {
    /// The detections in an image, by track.
    pub(super) fn read(
        &mut self,
        step: usize,
        name: &str,
        boxes: &[LabelledBox],
        world_from_camera: &Pose,
    ) -> Vec<Found> {
        let mut found: Vec<Found> = Vec::new();
        if boxes.is_empty() {
            return found;
        }
        let file = image_file(self.folder, name);
        let Some(photo) = self.photo(name, step, *world_from_camera) else { return found };
        for labelled in boxes {
            match self.found(&photo, labelled) {
                Ok(new) if found.iter().any(|old| old.detection.track == new.detection.track) => {
                    self.report.skip(&file, format!("instance {} twice in one image", labelled.4));
                }
                Ok(new) => found.push(new),
                Err(reason) => self.report.skip(&file, reason),
            }
        }
        found.sort_by_key(|found| found.detection.track);
        found
    }

    fn photo(&mut self, name: &str, step: usize, world_from_camera: Pose) -> Option<Photo> {
        let file = image_file(self.folder, name);
        let image = read_jpeg(&file).map_err(|error| self.report.skip(&file, error)).ok()?;
        let size = Vector2::new(f64::from(image.width()), f64::from(image.height()));
        let full = Vector2::new(f64::from(self.camera.width), f64::from(self.camera.height));
        let scale = size.component_div(&full);
        if (scale.x / scale.y - 1.0).abs() > SAME_SHAPE {
            let [size, full] = [size, full].map(|size| format!("{} x {}", size.x, size.y));
            self.report.skip(&file, format!("{size} pixels, and the camera has {full}"));
            return None;
        }
        let ids = vec![0; image.width() as usize * image.height() as usize];
        let depth = self.depth(name, image.dimensions());
        Some(Photo { step, world_from_camera, image, ids, scale, depth })
    }

    /// The depth of an image of some size: it has that size, or the camera's.
    fn depth(&mut self, image: &str, (width, height): (u32, u32)) -> Option<DepthImage> {
        let file = self.folder.join("high_res_depth").join(depth_of(image)?);
        let depth = read_depth(&file).map_err(|error| self.report.skip(&file, error)).ok()?;
        let sizes = [(width, height), (self.camera.width, self.camera.height)];
        if sizes.contains(&depth.dimensions()) {
            return Some(depth);
        }
        let [got, image] =
            [depth.dimensions(), sizes[0]].map(|(width, height)| format!("{width} x {height}"));
        self.report.skip(&file, format!("{got} pixels, and the image has {image}"));
        None
    }

    fn found(&self, photo: &Photo, labelled: &LabelledBox) -> Result<Found, String> {
        let LabelledBox(x0, y0, x1, y1, id, difficulty) = *labelled;
        let name = self.names.get(&id).ok_or_else(|| format!("a box of instance {id}, which has no name"))?;
        let track = self.present.iter().position(|present| present == name);
        let track = track.ok_or_else(|| format!("a box of {name}, which is not in {}", labels::PRESENT))?;
        let clip = |x: f64, side: u32| x.clamp(0.0, f64::from(side));
        let min = Vector2::new(clip(x0, self.camera.width), clip(y0, self.camera.height));
        let max = Vector2::new(clip(x1, self.camera.width), clip(y1, self.camera.height));
        if !(min.x < max.x && min.y < max.y) {
            return Err(format!("a box of {name}, {x0} {y0} {x1} {y1}, without a pixel of the image"));
        }
        let seen = BoundingBox { min, max };
        let bounding_box = self
            .ideal(&seen)
            .ok_or_else(|| format!("a box of {name} where the lens's distortion cannot be undone"))?;
        let in_image =
            BoundingBox { min: min.component_mul(&photo.scale), max: max.component_mul(&photo.scale) };
        let image =
            Labelled { width: photo.image.width() as usize, rgb: photo.image.as_raw(), ids: &photo.ids };
        let crop = cut(&image, &Window::around(&in_image), None);
        let mask_pixels = ((max.x - min.x) * (max.y - min.y)).round().max(1.0) as u32;
        Ok(Found {
            detection: Detection {
                step: photo.step,
                track,
                bounding_box,
                mask_pixels,
                center_depth: None,
                masked_crop: crop.clone(),
                boxed_crop: crop,
            },
            evidence: Evidence {
                world_from_camera: photo.world_from_camera,
                center: bounding_box.center(),
                sides: bounding_box.max - bounding_box.min,
                depth: photo.depth.as_ref().and_then(|depth| core_depth(depth, &seen, &self.camera)),
                difficulty,
            },
        })
    }

    /// The box as an ideal lens would show it: the middles of its edges are moved, but for those on the border.
    fn ideal(&self, seen: &BoundingBox) -> Option<BoundingBox> {
        if self.lens == Lens::default() {
            return Some(*seen);
        }
        let center = seen.center();
        let full = [f64::from(self.camera.width), f64::from(self.camera.height)];
        let edge = |axis: usize, at: f64| {
            if at <= 0.0 || at >= full[axis] {
                return Some(at);
            }
            let mut middle = center;
            middle[axis] = at;
            Some(self.lens.undistort_pixel(&self.camera, &middle)?[axis])
        };
        let ideal = BoundingBox {
            min: Vector2::new(edge(0, seen.min.x)?, edge(1, seen.min.y)?),
            max: Vector2::new(edge(0, seen.max.x)?, edge(1, seen.max.y)?),
        };
        (ideal.min.x < ideal.max.x && ideal.min.y < ideal.max.y).then_some(ideal)
    }
}

/// The median depth, metres, in the middle of a box given in the camera's pixels.
fn core_depth(depth: &DepthImage, seen: &BoundingBox, camera: &Camera) -> Option<f64> {
    let (center, half) = (seen.center(), (seen.max - seen.min) * (CORE / 2.0));
    let range = |axis: usize, pixels: u32, full: u32| {
        let scale = f64::from(pixels) / f64::from(full);
        let first = ((center[axis] - half[axis]) * scale).floor().max(0.0) as u32;
        let end = ((center[axis] + half[axis]) * scale).ceil() as u32;
        first..end.min(pixels)
    };
    let columns = range(0, depth.width(), camera.width);
    let millimetres = range(1, depth.height(), camera.height)
        .flat_map(|row| columns.clone().map(move |column| depth.get_pixel(column, row).0[0]))
        .filter(|millimetres| *millimetres > 0);
    median(millimetres.map(|millimetres| f64::from(millimetres) / 1000.0).collect())
}
