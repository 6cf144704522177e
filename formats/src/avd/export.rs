//! Writes scans in the dataset's layout.

use super::annotations::{self, Written, difficulty};
use super::grid::Station;
use super::images::{self, WrittenImage};
use super::import::z_up_from_y_down;
use super::movement::Movement;
use super::name::{self, ScanName};
use super::{HEADINGS, camera, labels};
use crate::import::ImportError;
use crate::picture::{write_depth, write_jpeg};
use crate::{make_empty, object_name};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Fault, StoreError};
use vantage_dataset::{BoundingBox, Camera, Capture, ObjectTruth};

/// Indices of images have six digits.
const MOST_CLUSTERS: u32 = 999_999 / HEADINGS;

/// Writes the folder of one scan, image by image.
///
/// The reconstruction's frame is the world's with y down and z along the world's x; its unit is the metre. The map of
/// instances above the scans is extended by the objects of this one. Pointers and poses are written last.
#[derive(Debug)]
pub struct AvdWriter {
    folder: PathBuf,
    scan: ScanName,
    camera: Camera,
    /// Name and number of each track's object.
    objects: Vec<(String, u32)>,
    seen: BTreeSet<usize>,
    /// Sorted by index at the end.
    shots: Vec<Shot>,
}

/// What is kept of an image.
#[derive(Debug)]
struct Shot {
    station: Station,
    boxes: Vec<[u32; 6]>,
    image: WrittenImage,
}

impl AvdWriter {
    /// Makes the folder `root/<scan>`, which must be empty if it is there.
    ///
    /// `objects` are in the order of the captures' tracks.
    pub fn create(
        root: &Path,
        scan: ScanName,
        camera: Camera,
        objects: &[ObjectTruth],
    ) -> Result<Self, StoreError> {
        let folder = root.join(scan.to_string());
        make_empty(&folder)?;
        for part in ["jpg_rgb", "high_res_depth"] {
            std::fs::create_dir(folder.join(part)).map_err(StoreError::write(&folder))?;
        }
        let names: Vec<String> = objects.iter().map(object_name).collect();
        if let Some(twice) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
            return Err(unfit(&folder, labels::PRESENT, "names", twice.1, "each object once in a scan"));
        }
        let numbered = number(root, &names)?;
        camera::write(&folder, &camera)?;
        let objects = names.into_iter().zip(numbered).collect();
        Ok(Self { folder, scan, camera, objects, seen: BTreeSet::new(), shots: Vec::new() })
    }

    /// Writes the image of a cluster, which is a point of the grid, in a heading: 0 to 11, counter-clockwise.
    pub fn push(&mut self, cluster: u32, heading: u32, capture: &Capture) -> Result<(), StoreError> {
        let folder = self.folder.clone();
        if heading >= HEADINGS || cluster >= MOST_CLUSTERS {
            let got = format!("{cluster}, {heading}");
            let expected = format!("less than {MOST_CLUSTERS}, {HEADINGS}");
            return Err(unfit(&folder, "image", "cluster, heading", got, &expected));
        }
        let index = cluster * HEADINGS + heading + 1;
        let name = name::image(&self.scan, index);
        let pixels = self.camera.width as usize * self.camera.height as usize;
        if capture.camera != self.camera || capture.rgb.len() != 3 * pixels || capture.depth.len() != pixels {
            return Err(unfit(&folder, &name, "camera", "other intrinsics or pixels", "those of the scan"));
        }
        if self.shots.iter().any(|shot| shot.image.image_id == index) {
            return Err(unfit(&folder, &name, "image", "a second one", "one of a cluster and heading"));
        }
        let mut boxes = Vec::new();
        for object in &capture.objects {
            let Some((_, id)) = self.objects.get(object.track) else {
                let expected = format!("less than {}", self.objects.len());
                return Err(unfit(&folder, &name, "track", object.track, &expected));
            };
            boxes.push(labelled(&object.visible_box, *id, self.camera.width));
            self.seen.insert(object.track);
        }
        let Camera { width, height, .. } = self.camera;
        write_jpeg(&folder.join("jpg_rgb").join(&name), &capture.rgb, width, height)?;
        if let Some(depth) = name::depth_of(&name) {
            let path = folder.join("high_res_depth").join(depth);
            write_depth(&path, &millimetres(&capture.depth), width, height)?;
        }
        let camera_from_world = capture.world_from_camera.inverse() * z_up_from_y_down();
        self.shots.push(Shot {
            station: Station::new(cluster, heading, &capture.world_from_camera),
            boxes,
            image: WrittenImage {
                name,
                camera_from_world,
                image_id: index,
                cluster_id: cluster + 1,
                moves: Default::default(),
            },
        });
        Ok(())
    }

    /// Writes the annotations, the poses and the names of the instances that were seen.
    pub fn finish(mut self) -> Result<(), StoreError> {
        self.shots.sort_by_key(|shot| shot.image.image_id);
        let stations: Vec<Station> = self.shots.iter().map(|shot| shot.station).collect();
        let names: Vec<String> = self.shots.iter().map(|shot| shot.image.name.clone()).collect();
        let mut annotations = BTreeMap::new();
        for shot in &mut self.shots {
            let leads = |movement| {
                let target: Option<usize> = shot.station.target(movement, &stations);
                target.map(|target| names[target].clone())
            };
            let [rotate_cw, rotate_ccw, forward, backward, right, left] = [
                Movement::RotateCw,
                Movement::RotateCcw,
                Movement::Forward,
                Movement::Backward,
                Movement::Right,
                Movement::Left,
            ]
            .map(leads);
            shot.image.moves =
                [&rotate_cw, &rotate_ccw, &forward, &backward, &right, &left].map(Clone::clone);
            let written = Written {
                bounding_boxes: std::mem::take(&mut shot.boxes),
                rotate_ccw: rotate_ccw.unwrap_or_default(),
                rotate_cw: rotate_cw.unwrap_or_default(),
                forward: forward.unwrap_or_default(),
                backward: backward.unwrap_or_default(),
                left: left.unwrap_or_default(),
                right: right.unwrap_or_default(),
            };
            annotations.insert(shot.image.name.clone(), written);
        }
        annotations::write(&self.folder, &annotations)?;
        let present = self.objects.iter().enumerate().filter(|(track, _)| self.seen.contains(track));
        labels::write_present(&self.folder, present.map(|(_, (name, _))| name.as_str()))?;
        let images: Vec<WrittenImage> = self.shots.into_iter().map(|shot| shot.image).collect();
        let path = self.folder.join(images::FILE);
        std::fs::write(&path, images::encode(&images)).map_err(StoreError::write(&path))
    }
}

/// The numbers of these names in the map above the scans, which is extended by the new ones.
fn number(root: &Path, names: &[String]) -> Result<Vec<u32>, StoreError> {
    let path = root.join(labels::ID_MAP);
    let mut known = match labels::read_text_map(&path) {
        Ok(known) => known,
        Err(error) if error.is_absence() => BTreeMap::from([(0, "background".to_owned())]),
        Err(ImportError::Read { path, source }) => return Err(StoreError::Read { path, source }),
        Err(ImportError::Invalid(problem)) => {
            return Err(unfit(root, labels::ID_MAP, &problem.field, &problem.got, &problem.expected));
        }
    };
    let numbers = names
        .iter()
        .map(|name| {
            let old = known.iter().find(|(_, known)| *known == name).map(|(id, _)| *id);
            old.unwrap_or_else(|| {
                let new = known.last_key_value().map_or(1, |(id, _)| id + 1);
                known.insert(new, name.clone());
                new
            })
        })
        .collect();
    labels::write(root, &known)?;
    Ok(numbers)
}

fn labelled(visible: &BoundingBox, id: u32, image_width: u32) -> [u32; 6] {
    let sides = visible.max - visible.min;
    let [x0, y0] = [visible.min.x, visible.min.y].map(|at| at as u32);
    let [x1, y1] = [visible.max.x, visible.max.y].map(|at| at as u32);
    [x0, y0, x1, y1, id, u32::from(difficulty(sides.x, sides.y, image_width))]
}

fn millimetres(depth: &[f32]) -> Vec<u16> {
    let millimetres = depth.iter().map(|metres| f64::from(*metres) * 1000.0);
    millimetres.map(|depth| if depth <= f64::from(u16::MAX) { depth.round() as u16 } else { 0 }).collect()
}

fn unfit(folder: &Path, file: &str, field: &str, got: impl ToString, expected: &str) -> StoreError {
    StoreError::unfit(folder)(Fault::new(file, None, field, got, expected))
}
