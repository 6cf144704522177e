//! Reads scenes in BOP's folders as episodes: camera poses from poses of objects, one episode an arrangement of them.

mod arrangement;
mod files;
mod images;
mod json;
mod masks;
mod mesh;
mod places;
mod seen;
mod symmetry;
mod upright;

use crate::avd::odometry;
use crate::import::{ImportError, ImportReport};
use crate::level_robot::robot_from_camera;
use arrangement::{Arrangement, arrangements};
use files::{Frame, read_frames};
pub use masks::Silhouettes;
pub use mesh::{MeshGeometry, ReadModel};
use nalgebra::{Translation3, UnitQuaternion};
pub use places::BopScenes;
use places::GT;
use seen::Sights;
use std::path::Path;
use upright::{Upright, upright};
use vantage_dataset::{
    DetectionTruth, Episode, InstanceId, ObjectTruth, Observations, Pose, Seed, Symmetry, Truth,
};

/// Fewer images tell nothing of a robot's way.
const LEAST_IMAGES: usize = 3;

/// Which detections count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionLimits {
    /// Least visible share of an object's silhouette.
    pub min_visible_fraction: f64,
    /// Least number of visible pixels.
    pub min_mask_pixels: u32,
}

/// Images in a row during which objects stood still.
#[derive(Clone, Debug)]
pub struct BopArrangement {
    /// `SCENE_NUMBER`.
    pub name: String,
    /// What was seen, and what was true; its seed says nothing.
    pub episode: Episode,
}

impl BopScenes {
    /// Reads one of [`BopScenes::scenes`].
    ///
    /// Steps are the images of an arrangement in the order of their numbers, one a second. An arrangement goes on as long as two in three of
    /// its objects have not moved; objects that have moved by its end are none of its tracks. The camera's pose is that of
    /// `cam_R_w2c` where it is given, and the one that most standing objects agree on elsewhere, two at least but for
    /// [`BopScenes::lone_object_stands`].
    ///
    /// The world's z axis is the one that most models' z axes have in common, or that of `cam_R_w2c`. An object's frame has its origin at
    /// the centre of its model's bounding box and the model's axes; that of an object that does not stand on its base is upright
    /// instead, and the object an instance of this arrangement alone. The robot and the odometry are as in
    /// [`read_scan`](crate::avd::read_scan).
    ///
    /// # Errors
    ///
    /// Annotations that are missing, are no JSON or contradict the layout, translations in another unit than sizes, and an "up" that nothing
    /// tells.
    pub fn read(
        &self,
        scene: &Path,
        limits: &DetectionLimits,
        silhouettes: &mut dyn Silhouettes,
        report: &mut ImportReport,
    ) -> Result<Vec<BopArrangement>, ImportError> {
        let frames = read_frames(scene, report)?;
        self.check_unit(scene, &frames)?;
        let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut read = Vec::new();
        let mut faint = 0;
        for (number, arrangement) in arrangements(&frames, self.lone_object_stands).into_iter().enumerate() {
            let name = format!("{name}_{number:02}");
            if arrangement.frames.len() < LEAST_IMAGES {
                let images = arrangement.frames.len();
                report
                    .skip(scene, format!("arrangement {number}: {images} images, fewer than {LEAST_IMAGES}"));
                continue;
            }
            if arrangement.placements.is_empty() {
                report.skip(scene, format!("arrangement {number}: no object stands still"));
                continue;
            }
            for key in &arrangement.moved {
                report.skip(scene, format!("arrangement {number}: object {key} moved and is no track of it"));
            }
            let upright = upright(scene, &frames, &arrangement)?;
            let mut sights = Sights { scene, models: &self.models, limits, silhouettes, report, faint };
            read.extend(self.episode(&name, &arrangement, &upright, &mut sights));
            faint = sights.faint;
        }
        if faint > 0 {
            report.skip(scene, format!("{faint} detections, of which too little is visible"));
        }
        Ok(read)
    }

    /// Refuses poses that put most objects within half their size of the camera: their translations are not in millimetres.
    fn check_unit(&self, scene: &Path, frames: &[Frame]) -> Result<(), ImportError> {
        let (mut all, mut near) = (0, 0);
        for object in frames.iter().flat_map(|frame| &frame.objects) {
            let Some(model) = self.models.get(&object.key.object) else { continue };
            all += 1;
            near += usize::from(object.camera_from_model.translation.vector.norm() < model.size / 2.0);
        }
        if 2 * near <= all {
            return Ok(());
        }
        let got = format!("{near} of {all} objects nearer to the camera than half their size");
        let remedy = "give translations and sizes in the same unit, as BOP does";
        Err(ImportError::invalid(&scene.join(GT), "cam_t_m2c", got, "millimetres", remedy))
    }

    fn episode(
        &self,
        name: &str,
        arrangement: &Arrangement<'_>,
        upright: &Upright,
        sights: &mut Sights<'_>,
    ) -> Option<BopArrangement> {
        let mut objects = Vec::new();
        let mut tracks = Vec::new();
        for (key, pose) in &arrangement.placements {
            let Some(model) = self.models.get(&key.object) else {
                sights.report.skip(&self.models_info, format!("object {key}: no entry, and so no model"));
                continue;
            };
            tracks.push(*key);
            objects.push(self.object(name, key.object, model, &(upright.world_from_arrangement * pose)));
        }
        let seen = sights.see(arrangement, &tracks);
        let camera = seen.camera?;
        let world_from_camera: Vec<Pose> = seen
            .frames
            .iter()
            .map(|&frame| upright.world_from_arrangement * arrangement.arrangement_from_camera[frame])
            .collect();
        let robot_from_camera = robot_from_camera(world_from_camera.first()?);
        let world_from_robot: Vec<Pose> =
            world_from_camera.iter().map(|pose| pose * robot_from_camera.inverse()).collect();
        if world_from_robot.len() < LEAST_IMAGES {
            sights
                .report
                .skip(sights.scene, format!("{name}: fewer than {LEAST_IMAGES} images that can be read"));
            return None;
        }
        if seen.detections.is_empty() {
            sights.report.skip(sights.scene, format!("{name}: no object is seen well enough"));
            return None;
        }
        let observations = Observations {
            timestamps: (0..world_from_robot.len()).map(|step| step as f64).collect(),
            camera,
            robot_from_camera,
            odometry: odometry(&world_from_robot),
            detections: seen.detections,
            landmarks: Vec::new(),
        };
        let visible = seen.visible_fractions.into_iter();
        let truth = Truth {
            world_from_robot,
            objects,
            landmarks: Vec::new(),
            detections: visible.map(|visible_fraction| DetectionTruth { visible_fraction }).collect(),
        };
        let name = name.to_owned();
        Some(BopArrangement { name, episode: Episode { seed: Seed(0), observations, truth } })
    }

    fn object(&self, arrangement: &str, id: u32, model: &ReadModel, world_from_model: &Pose) -> ObjectTruth {
        let family = format!("obj_{id:06}");
        let name = format!("{}/{family}", self.dataset);
        let world_from_object = world_from_model * Translation3::from(model.center);
        let stands = upright::stands(&world_from_object);
        let (instance, pose) = if stands {
            (InstanceId::of_name(&name), world_from_object)
        } else {
            let lying = Pose::from_parts(world_from_object.translation, UnitQuaternion::identity());
            (InstanceId::of_name(&format!("{name} lying in {arrangement}")), lying)
        };
        ObjectTruth {
            instance,
            family,
            world_from_object: pose,
            size: model.size,
            symmetry: if stands { model.symmetry } else { Symmetry::None },
            extents: None,
        }
    }
}
