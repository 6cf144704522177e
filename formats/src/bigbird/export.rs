//! Writes objects in BigBIRD's layout.

use super::calibration::{self, Calibrated};
use super::name::ImageName;
use super::table::{write_axis, write_pose};
use super::{CALIBRATION, CAMERAS, REFERENCE};
use crate::hdf5::write_image;
use crate::picture::{write_jpeg, write_pbm};
use crate::{make_empty, object_name};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Fault, StoreError};
use vantage_dataset::{Camera, Capture, ObjectTruth, Pose};

/// Depth images have this size whatever that of the colour images is.
const DEPTH_WIDTH: u32 = 640;
const DEPTH_HEIGHT: u32 = 480;
/// Depth of one unit, metres.
const DEPTH_UNIT: f64 = 1e-4;
/// How far the cameras may have moved in each other's frames, metres and radians.
const RIGID: f64 = 1e-6;

/// Writes the folder of one object, image by image.
///
/// The cameras must be rigid in each other's frames, as the rig's are, and camera 5, the reference, must have an image
/// at every angle. Lenses are ideal, and each depth camera stands where its colour camera does. `calibration.h5` is
/// written last.
#[derive(Debug)]
pub struct BigBirdWriter {
    folder: PathBuf,
    track: usize,
    world_from_table: Pose,
    /// `table_from_camera` by angle, then camera.
    poses: BTreeMap<u32, [Option<Pose>; CAMERAS]>,
    cameras: [Option<Camera>; CAMERAS],
}

impl BigBirdWriter {
    /// Makes the folder `root/<family>_<id>`, which must be empty if it is there.
    ///
    /// `track` is the object's index in the captures. The table's frame has z up and turns with the object.
    pub fn create(
        root: &Path,
        object: &ObjectTruth,
        track: usize,
        world_from_table: Pose,
    ) -> Result<Self, StoreError> {
        let folder = root.join(object_name(object));
        make_empty(&folder)?;
        for part in ["masks", "poses"] {
            std::fs::create_dir(folder.join(part)).map_err(StoreError::write(&folder))?;
        }
        Ok(Self { folder, track, world_from_table, poses: BTreeMap::new(), cameras: [None; CAMERAS] })
    }

    /// Writes the image of a camera, 1 to 5, after a turn of `angle` degrees, its depth and its mask.
    pub fn push(&mut self, camera: usize, angle: u32, capture: &Capture) -> Result<(), StoreError> {
        let name = ImageName { angle, camera };
        if !(1..=CAMERAS).contains(&camera) {
            return Err(self.unfit(name, "camera", camera, "1 to 5"));
        }
        if self.cameras[camera - 1].is_some_and(|known| known != capture.camera) {
            return Err(self.unfit(name, "camera", "other intrinsics", "those of the images before"));
        }
        let pixels = capture.camera.width as usize * capture.camera.height as usize;
        if capture.rgb.len() != 3 * pixels || capture.depth.len() != pixels || capture.ids.len() != pixels {
            return Err(self.unfit(name, "pixels", capture.ids.len(), &format!("{pixels}")));
        }
        let place = &mut self.poses.entry(angle).or_default()[camera - 1];
        if place.replace(self.world_from_table.inv_mul(&capture.world_from_camera)).is_some() {
            return Err(self.unfit(name, "image", "a second one", "one of a camera and angle"));
        }
        self.cameras[camera - 1] = Some(capture.camera);

        let Camera { width, height, .. } = capture.camera;
        write_jpeg(&self.folder.join(name.image()), &capture.rgb, width, height)?;
        let depth = depth_image(capture);
        write_image(&self.folder.join(name.depth()), "depth", &depth, DEPTH_WIDTH as usize)?;
        let object = self.track as u32 + 1;
        let black: Vec<bool> = capture.ids.iter().map(|id| *id == object).collect();
        write_pbm(&self.folder.join(name.mask()), &black, width as usize)
    }

    /// Writes the poses, the axis and the calibration.
    pub fn finish(self) -> Result<(), StoreError> {
        let mut transforms: [Option<Pose>; CAMERAS] = [None; CAMERAS];
        for (&angle, poses) in &self.poses {
            let Some(table_from_reference) = &poses[REFERENCE - 1] else {
                let name = ImageName { angle, camera: REFERENCE };
                return Err(self.unfit(name, "image", "none", "one of the reference camera at every angle"));
            };
            write_pose(&self.folder, angle, table_from_reference)?;
            for (index, pose) in poses.iter().enumerate() {
                let Some(table_from_camera) = pose else { continue };
                let camera_from_reference = table_from_camera.inv_mul(table_from_reference);
                let known = transforms[index].get_or_insert(camera_from_reference);
                let moved = known.inv_mul(&camera_from_reference);
                if moved.rotation.angle().max(moved.translation.vector.norm()) > RIGID {
                    let name = ImageName { angle, camera: index + 1 };
                    return Err(self.unfit(name, "pose", moved, "the camera to stay in the rig"));
                }
            }
        }
        write_axis(&self.folder)?;
        let cameras: [Option<Calibrated>; CAMERAS] = std::array::from_fn(|index| {
            let color = self.cameras[index]?;
            let camera_from_reference = transforms[index]?;
            Some(Calibrated { camera_from_reference, color, depth: depth_camera(&color) })
        });
        calibration::write(&self.folder.join(CALIBRATION), &cameras)
    }

    fn unfit(&self, name: ImageName, field: &str, got: impl ToString, expected: &str) -> StoreError {
        StoreError::unfit(&self.folder)(Fault::new(&name.image(), None, field, got, expected))
    }
}

/// As wide a view as the colour camera's, with square steps.
fn depth_camera(color: &Camera) -> Camera {
    let scale = f64::from(DEPTH_WIDTH) / f64::from(color.width);
    Camera {
        width: DEPTH_WIDTH,
        height: DEPTH_HEIGHT,
        fx: color.fx * scale,
        fy: color.fy * scale,
        cx: color.cx * scale,
        cy: f64::from(DEPTH_HEIGHT) / 2.0 + (color.cy - f64::from(color.height) / 2.0) * scale,
    }
}

/// Depth of the nearest pixel of the colour image, in tenths of a millimetre; 0 where there is none.
fn depth_image(capture: &Capture) -> Vec<u16> {
    let color = &capture.camera;
    let depth = depth_camera(color);
    let nearest = |at: u32, center: f64, focal: f64, to_center: f64, to_focal: f64, side: u32| {
        let pixel = ((f64::from(at) + 0.5 - center) / focal * to_focal + to_center).floor();
        (pixel >= 0.0 && pixel < f64::from(side)).then_some(pixel as usize)
    };
    let columns: Vec<Option<usize>> =
        (0..DEPTH_WIDTH).map(|x| nearest(x, depth.cx, depth.fx, color.cx, color.fx, color.width)).collect();
    (0..DEPTH_HEIGHT)
        .map(|y| nearest(y, depth.cy, depth.fy, color.cy, color.fy, color.height))
        .flat_map(|row| columns.iter().map(move |column| Some((row?, (*column)?))))
        .map(|pixel| {
            let Some((row, column)) = pixel else { return 0 };
            let units = f64::from(capture.depth[row * color.width as usize + column]) / DEPTH_UNIT;
            if units <= f64::from(u16::MAX) { units.round() as u16 } else { 0 }
        })
        .collect()
}
