//! Reads scans as episodes.

use super::annotations::{self, Annotations};
use super::boxes::{BoxReader, Found};
use super::images::{self, ScanImage};
use super::movement_graph::MovementGraph;
use super::name::image_file;
use super::objects::{Evidence, place};
use super::{camera, labels};
use crate::Lens;
use crate::import::{FETCH_AGAIN, ImportError, ImportReport};
use crate::level_robot::robot_from_camera;
use nalgebra::{Matrix3, Matrix6, Rotation3, Translation3, UnitQuaternion, Vector3, Vector6};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use vantage_dataset::{
    Camera, DetectionTruth, Episode, InstanceId, ObjectTruth, Observations, Odometry, Pose, Seed, Symmetry,
    Truth,
};

/// Stated standard deviation of an odometry's rotation about each axis, radians.
pub const ODOMETRY_ROTATION_SIGMA: f64 = 0.01;
/// Stated standard deviation of an odometry's translation along each axis, metres.
pub const ODOMETRY_TRANSLATION_SIGMA: f64 = 0.01;
/// The cosine that the cameras' mean "down" must at least have to the world's y axis.
const UPRIGHT: f64 = 0.5;

/// A scan.
#[derive(Clone, Debug)]
pub struct AvdScan {
    /// What was seen, and what was true.
    pub episode: Episode,
    /// Where each movement leads.
    pub movements: MovementGraph,
    /// File name of each step's image.
    pub images: Vec<String>,
    /// Distortion of the images, of which boxes are freed and crops are not.
    pub lens: Lens,
    /// What was left out. Its `views` are the detections.
    pub report: ImportReport,
    pub(super) folder: PathBuf,
}

/// Turns a world whose y axis points down to one whose z axis points up.
pub(super) fn z_up_from_y_down() -> Pose {
    rotation(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0))
}

fn rotation(matrix: Matrix3<f64>) -> Pose {
    let rotation = Rotation3::from_matrix_unchecked(matrix);
    Pose::from_parts(Translation3::identity(), UnitQuaternion::from_rotation_matrix(&rotation))
}

/// Reads the scan in `folder`.
///
/// Steps are the registered images in the order of their names, one a second. Positions are in metres, and the world's
/// z axis is the vertical y axis of the reconstruction, upward. The robot stands at the camera and is level at the first
/// step; its x axis heads there where the camera looks. The odometry is the true motion, with a covariance that is merely
/// stated ([`ODOMETRY_ROTATION_SIGMA`], [`ODOMETRY_TRANSLATION_SIGMA`]): add noise for an honest trial.
///
/// Boxes are freed of the lens's distortion, edges on the image's border excepted, so that the episode's ideal camera
/// fits them; crops are cut from images as they are. There are no masks: the masked crop is the boxed one, and the
/// pixels of a mask are those of its box. Tracks follow `present_instance_names.txt`, without instances of which no box
/// could be placed. Objects have an identity orientation and no symmetry, as neither is known; every visible fraction
/// is 1 for the same reason. `images` may be smaller than the camera, in its shape: boxes then keep the camera's pixels.
pub fn read_scan(folder: &Path) -> Result<AvdScan, ImportError> {
    let annotations = annotations::read(folder)?;
    let (camera, lens) = camera::read(folder)?;
    let names = labels::read(folder)?;
    let mut report = ImportReport::default();
    let registered = registered(folder, &annotations, &mut report)?;
    let upright = world_from_reconstruction(folder, &registered)?;
    let world_from_camera: Vec<Pose> = registered.iter().map(|(_, pose)| upright * pose.inverse()).collect();
    let present = present(folder, &annotations, &names)?;

    let mut reader = BoxReader { folder, camera, lens, names: &names, present: &present, report };
    let mut found = Vec::new();
    for (step, ((name, _), pose)) in registered.iter().zip(&world_from_camera).enumerate() {
        let boxes = annotations.get(name).map(|a| a.bounding_boxes.as_slice()).unwrap_or_default();
        found.extend(reader.read(step, name, boxes, pose));
    }
    let mut report = reader.report;
    let objects = objects(folder, &camera, &present, &mut found, &mut report);
    report.views = found.len();

    let images: Vec<String> = registered.into_iter().map(|(name, _)| name).collect();
    let robot_from_camera = robot_from_camera(&world_from_camera[0]);
    let world_from_robot: Vec<Pose> =
        world_from_camera.iter().map(|pose| pose * robot_from_camera.inverse()).collect();
    let scan = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let observations = Observations {
        timestamps: (0..images.len()).map(|step| step as f64).collect(),
        camera,
        robot_from_camera,
        odometry: odometry(&world_from_robot),
        detections: found.iter().map(|found| found.detection.clone()).collect(),
        landmarks: Vec::new(),
    };
    let truth = Truth {
        world_from_robot,
        objects,
        landmarks: Vec::new(),
        detections: found.iter().map(|_| DetectionTruth { visible_fraction: 1.0 }).collect(),
    };
    Ok(AvdScan {
        episode: Episode { seed: Seed(InstanceId::of_name(&scan).0), observations, truth },
        movements: MovementGraph::new(&images, &annotations),
        images,
        lens,
        report,
        folder: folder.to_owned(),
    })
}

/// Names and `camera_from_world` of the images that can be steps.
fn registered(
    folder: &Path,
    annotations: &Annotations,
    report: &mut ImportReport,
) -> Result<Vec<(String, Pose)>, ImportError> {
    let images = images::read(folder)?;
    let known: BTreeSet<&str> = images.iter().map(|image| image.name.as_str()).collect();
    for name in annotations.keys().filter(|name| !known.contains(name.as_str())) {
        report.skip(image_file(folder, name), format!("annotated, but not in {}", images::FILE));
    }
    let mut registered = Vec::new();
    for ScanImage { name, pose } in images {
        let file = image_file(folder, &name);
        match pose {
            Err(reason) => report.skip(file, reason),
            Ok(_) if name.contains(['/', '\\']) || !file.is_file() => report.skip(file, "no image"),
            Ok(pose) => registered.push((name, pose)),
        }
    }
    if registered.is_empty() {
        let path = folder.join(images::FILE);
        let remedy = "check that jpg_rgb and image_structs.mat are of one scan";
        return Err(ImportError::invalid(&path, "image_structs", "none", "a registered image", remedy));
    }
    Ok(registered)
}

/// Turns the reconstruction's vertical y axis, which may point up or down, to z.
fn world_from_reconstruction(folder: &Path, images: &[(String, Pose)]) -> Result<Pose, ImportError> {
    let down: Vector3<f64> = images.iter().map(|(_, pose)| pose.rotation.inverse() * Vector3::y()).sum();
    let cosine = down.y / down.norm().max(f64::MIN_POSITIVE);
    if cosine.abs() < UPRIGHT {
        let path = folder.join(images::FILE);
        let got = format!("{:?}", (down / images.len() as f64).as_slice());
        let remedy = "turn the reconstruction so that y is vertical";
        return Err(ImportError::invalid(&path, "R, mean direction of down", got, "along y", remedy));
    }
    if cosine > 0.0 {
        return Ok(z_up_from_y_down());
    }
    Ok(rotation(Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)))
}

/// The instances present, by name.
fn present(
    folder: &Path,
    annotations: &Annotations,
    names: &BTreeMap<u32, String>,
) -> Result<Vec<String>, ImportError> {
    if let Some(present) = labels::read_present(folder)? {
        let mut known = BTreeSet::new();
        if let Some(twice) = present.iter().find(|name| !known.insert(name.as_str())) {
            let path = folder.join(labels::PRESENT);
            return Err(ImportError::invalid(&path, "names", twice, "each name once", FETCH_AGAIN));
        }
        return Ok(present);
    }
    let boxes = annotations.values().flat_map(|annotation| &annotation.bounding_boxes);
    let ids: BTreeSet<u32> = boxes.map(|labelled| labelled.4).collect();
    Ok(ids.iter().filter_map(|id| names.get(id).cloned()).collect())
}

/// Places the objects, and renumbers the tracks by those that could be.
fn objects(
    folder: &Path,
    camera: &Camera,
    present: &[String],
    found: &mut Vec<Found>,
    report: &mut ImportReport,
) -> Vec<ObjectTruth> {
    let mut objects = Vec::new();
    let mut tracks = vec![None; present.len()];
    for (old, name) in present.iter().enumerate() {
        let boxes = found.iter().filter(|found| found.detection.track == old);
        let evidence: Vec<Evidence> = boxes.map(|found| found.evidence.clone()).collect();
        let Some((position, size)) = place(camera, &evidence) else {
            let reason = format!("{name}: its {} boxes do not tell where it is", evidence.len());
            report.skip(folder.join(labels::PRESENT), reason);
            continue;
        };
        tracks[old] = Some(objects.len());
        objects.push(ObjectTruth {
            instance: InstanceId::of_name(name),
            family: name.clone(),
            world_from_object: Pose::from_parts(Translation3::from(position), UnitQuaternion::identity()),
            size,
            symmetry: Symmetry::None,
            extents: None,
        });
    }
    found.retain_mut(|found| {
        let track = tracks[found.detection.track];
        found.detection.track = track.unwrap_or_default();
        track.is_some()
    });
    objects
}

/// The true motion, with a covariance that is merely stated.
pub(crate) fn odometry(world_from_robot: &[Pose]) -> Vec<Odometry> {
    let (r, t) = (ODOMETRY_ROTATION_SIGMA.powi(2), ODOMETRY_TRANSLATION_SIGMA.powi(2));
    let covariance = Matrix6::from_diagonal(&Vector6::new(r, r, r, t, t, t));
    let pairs = world_from_robot.windows(2).enumerate();
    pairs
        .map(|(from, pair)| Odometry {
            from,
            to: from + 1,
            robot_from_robot: pair[0].inv_mul(&pair[1]),
            covariance,
        })
        .collect()
}
