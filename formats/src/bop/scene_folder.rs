//! A scene's folder: `rgb/`, `depth/`, `mask/`, `mask_visib/` and the four files that tell of all images.

use super::annotation::{Annotation, ImageCamera, ObjectInfo, ObjectPose};
use crate::image_file::{CompressionType, Pixels, png};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use vantage_dataset::Capture;

/// The folder under way; what its files hold of each image by the image's number.
pub(super) struct SceneFolder {
    path: PathBuf,
    scene: u32,
    cameras: BTreeMap<u32, ImageCamera>,
    poses: BTreeMap<u32, Vec<ObjectPose>>,
    infos: BTreeMap<u32, Vec<ObjectInfo>>,
    images: Vec<Value>,
    objects: Vec<Value>,
}

impl std::fmt::Debug for SceneFolder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SceneFolder({}, {} images)", self.path.display(), self.cameras.len())
    }
}

/// An image file of a capture.
enum Part<'a> {
    Rgb,
    Depth,
    Mask(usize, &'a [bool]),
    VisibleMask(usize, &'a [bool]),
}

impl SceneFolder {
    /// Makes the folder at `path`, in place of what is there.
    pub(super) fn create(path: &Path, scene: u32) -> io::Result<Self> {
        match fs::remove_dir_all(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        for part in ["rgb", "depth", "mask", "mask_visib"] {
            fs::create_dir_all(path.join(part))?;
        }
        Ok(Self {
            path: path.to_owned(),
            scene,
            cameras: BTreeMap::new(),
            poses: BTreeMap::new(),
            infos: BTreeMap::new(),
            images: Vec::new(),
            objects: Vec::new(),
        })
    }

    pub(super) fn scene(&self) -> u32 {
        self.scene
    }

    pub(super) fn add(
        &mut self,
        image: u32,
        capture: &Capture,
        annotation: Annotation<'_>,
    ) -> io::Result<()> {
        let (width, height) = (capture.camera.width, capture.camera.height);
        let masks = annotation.masks.iter().enumerate().map(|(i, mask)| Part::Mask(i, mask));
        let visible = annotation.visible_masks.iter().enumerate().map(|(i, mask)| Part::VisibleMask(i, mask));
        let parts: Vec<_> = [Part::Rgb, Part::Depth].into_iter().chain(masks).chain(visible).collect();
        let small = |pixels: Pixels<'_>| png(&pixels, width, height, CompressionType::Default);
        parts.par_iter().try_for_each(|part| {
            let (name, bytes) = match part {
                Part::Rgb => (format!("rgb/{image:06}.png"), small(Pixels::Rgb(&capture.rgb))?),
                Part::Depth => (format!("depth/{image:06}.png"), small(Pixels::Deep(&annotation.depth))?),
                Part::Mask(i, mask) => {
                    (format!("mask/{image:06}_{i:06}.png"), mask_png(mask, width, height)?)
                }
                Part::VisibleMask(i, mask) => {
                    (format!("mask_visib/{image:06}_{i:06}.png"), mask_png(mask, width, height)?)
                }
            };
            fs::write(self.path.join(name), bytes)
        })?;
        self.images.push(json!({
            "id": image, "file_name": format!("rgb/{image:06}.png"), "width": width, "height": height,
        }));
        self.objects.extend(annotation.coco(image, self.objects.len() + 1, width, height));
        self.cameras.insert(image, annotation.camera);
        self.poses.insert(image, annotation.poses);
        self.infos.insert(image, annotation.infos);
        Ok(())
    }

    /// Writes the four files; `dataset` is the name of the categories' category.
    pub(super) fn close(self, dataset: &str) -> io::Result<()> {
        let categories: BTreeSet<u32> = self.poses.values().flatten().map(|pose| pose.obj_id).collect();
        let category = |id: u32| json!({"id": id, "name": id.to_string(), "supercategory": dataset});
        let coco = json!({
            "info": {"description": dataset},
            "licenses": [],
            "categories": categories.into_iter().map(category).collect::<Vec<_>>(),
            "images": self.images,
            "annotations": self.objects,
        });
        write_json(&self.path.join("scene_camera.json"), &self.cameras)?;
        write_json(&self.path.join("scene_gt.json"), &self.poses)?;
        write_json(&self.path.join("scene_gt_info.json"), &self.infos)?;
        write_json(&self.path.join("scene_gt_coco.json"), &coco)
    }
}

fn mask_png(mask: &[bool], width: u32, height: u32) -> io::Result<Vec<u8>> {
    let grey: Vec<u8> = mask.iter().map(|&set| if set { u8::MAX } else { 0 }).collect();
    png(&Pixels::Grey(&grey), width, height, CompressionType::Default)
}

fn write_json(path: &Path, value: &impl Serialize) -> io::Result<()> {
    fs::write(path, serde_json::to_vec(value)?)
}
