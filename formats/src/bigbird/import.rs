//! Reads objects of BigBIRD as views with known viewpoints.

use super::CALIBRATION;
use super::calibration::{RigCamera, read_camera};
use super::name::{self, ImageName};
use super::silhouette::{OBJECT, Silhouette, Unfit};
use super::table::{read_pose, read_upright};
use crate::hdf5::Hdf5;
use crate::import::{ImportError, ImportReport};
use crate::meeting::meeting_point;
use crate::picture::{read_jpeg, read_pbm};
use crate::principal_point;
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use vantage_dataset::ray::Ray;
use vantage_dataset::views::InstanceRecord;
use vantage_dataset::window::{Labelled, Window, cut};
use vantage_dataset::{Crop, InstanceId, Pose, Split, Symmetry, View, ViewSet, Viewpoint};

/// Which of the views' radii, sorted, counts as the object's, so that a few bad masks do not.
const RADIUS_QUANTILE: f64 = 0.95;

/// The folders of objects in `root`, sorted: those with a `calibration.h5`.
pub fn object_folders(root: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let folders = names_in(root)?.into_iter().map(|name| root.join(name));
    Ok(folders.filter(|folder| folder.join(CALIBRATION).is_file()).collect())
}

/// The folders of objects in `root`, sorted, that have no `calibration.h5`.
pub fn uncalibrated_folders(root: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let folders = names_in(root)?.into_iter().map(|name| root.join(name));
    Ok(folders.filter(|folder| is_object(folder) && !folder.join(CALIBRATION).is_file()).collect())
}

/// Whether a folder holds a calibration, images, masks or poses of an object; one that cannot be read does not.
pub fn is_object(folder: &Path) -> bool {
    folder.join(CALIBRATION).is_file()
        || ["masks", "poses"].iter().any(|part| folder.join(part).is_dir())
        || images_in(folder).is_ok_and(|images| !images.is_empty())
}

fn images_in(folder: &Path) -> Result<BTreeSet<ImageName>, ImportError> {
    Ok(names_in(folder)?.iter().filter_map(|file| ImageName::parse(file)).collect())
}

/// Reads the views of objects, one folder each, of the angles (degrees) that `takes_angle` says.
///
/// Views are ordered by object, angle, camera. The frame of an object has the z axis of the turntable's normal, or of
/// the table's frame where `turntable.h5` is absent, and its origin where the rays through the centres of the masks'
/// boxes meet. Its size is twice the distance from there to the mask's farthest pixel, at the 95th percentile of the
/// views. Rays are freed of the lens's distortion; crops are cut from images as they are. Depth is not read.
///
/// What is missing, and masks that are empty or cut off by the border, are left out and reported.
///
/// # Errors
///
/// A folder without images or calibration, masks of which most are inverted, and files whose numbers cannot be
/// those of a rig.
pub fn read_objects(
    folders: &[PathBuf],
    split: Split,
    takes_angle: &dyn Fn(u32) -> bool,
) -> Result<(ViewSet, ImportReport), ImportError> {
    let mut set = ViewSet { split, instances: Vec::new(), views: Vec::new() };
    let mut report = ImportReport::default();
    let mut known = BTreeSet::new();
    for folder in folders {
        let family = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let id = InstanceId::of_name(&family);
        if !known.insert(id) {
            let expected = "each object once";
            return Err(ImportError::invalid(
                folder,
                "name",
                family,
                expected,
                "leave out one of the folders",
            ));
        }
        let sightings = sightings(folder, takes_angle, &mut report)?;
        let upright = read_upright(folder)?.unwrap_or(UnitQuaternion::identity());
        let views = views(folder, &sightings, upright, set.instances.len(), &mut report);
        if !views.is_empty() {
            set.instances.push(InstanceRecord { id, family, symmetry: Symmetry::None });
            set.views.extend(views);
        }
    }
    report.views = set.views.len();
    Ok((set, report))
}

/// The object as one image shows it.
struct Sighting {
    name: ImageName,
    table_from_camera: Pose,
    /// On the plane `z = 1` of the camera: the centre of the box, and the outline.
    center: Vector2<f64>,
    outline: Vec<Vector2<f64>>,
    crop: Crop,
}

impl Sighting {
    fn ray(&self) -> Ray {
        let direction = self.table_from_camera.rotation * self.center.push(1.0).normalize();
        Ray { origin: self.table_from_camera.translation.vector.into(), direction }
    }

    /// Distance from a point to the farthest ray through the outline, metres.
    fn radius(&self, point_in_table: &Point3<f64>) -> f64 {
        let point = self.table_from_camera.inverse() * point_in_table;
        let off = |ray: Vector3<f64>| ray.cross(&point.coords).norm() / ray.norm();
        self.outline.iter().map(|edge| off(edge.push(1.0))).fold(0.0, f64::max)
    }
}

fn sightings(
    folder: &Path,
    takes_angle: &dyn Fn(u32) -> bool,
    report: &mut ImportReport,
) -> Result<Vec<Sighting>, ImportError> {
    let images = images_in(folder)?;
    if images.is_empty() {
        let expected = "NP1_0.jpg and others";
        return Err(ImportError::invalid(folder, "images", "none", expected, "name a folder of one object"));
    }
    let calibration = Hdf5::open(&folder.join(CALIBRATION))?;
    let cameras: BTreeSet<usize> = images.iter().map(|image| image.camera).collect();
    let mut rig = BTreeMap::new();
    for &camera in &cameras {
        rig.insert(camera, read_camera(&calibration, camera)?);
    }
    let angles: BTreeSet<u32> = names_in(&folder.join("poses"))?
        .iter()
        .filter_map(|file| name::parse_pose(file))
        .chain(images.iter().map(|image| image.angle))
        .filter(|angle| takes_angle(*angle))
        .collect();

    let (mut sightings, mut inverted) = (Vec::new(), 0);
    for angle in angles {
        let table_from_reference = match read_pose(folder, angle) {
            Ok(pose) => pose,
            Err(error) => {
                report.skip(folder.join(name::pose(angle)), error);
                continue;
            }
        };
        for (&camera, calibrated) in &rig {
            let name = ImageName { angle, camera };
            if !images.contains(&name) {
                report.skip(folder.join(name.image()), "no image");
                continue;
            }
            match sighting(folder, name, &table_from_reference, calibrated) {
                Ok(sighting) => sightings.push(sighting),
                Err(Unusable::Mask(unfit)) => {
                    inverted += usize::from(unfit == Unfit::Inverted);
                    report.skip(folder.join(name.mask()), unfit.reason());
                }
                Err(Unusable::File(file, reason)) => report.skip(file, reason),
                Err(Unusable::Rig(error)) => return Err(error),
            }
        }
    }
    if inverted > sightings.len() {
        let masks = inverted + sightings.len();
        let got =
            format!("an object that fills the image or touches all its borders, in {inverted} of {masks}");
        let remedy = "invert the masks if the background is 0 when decoded, and not the object, or else leave out this \
                      object, which is too near";
        return Err(ImportError::invalid(
            &folder.join("masks"),
            "polarity",
            got,
            "the object to be 0",
            remedy,
        ));
    }
    Ok(sightings)
}

/// Why an image makes no view.
enum Unusable {
    Mask(Unfit),
    File(PathBuf, String),
    Rig(ImportError),
}

impl Unfit {
    fn reason(self) -> &'static str {
        match self {
            Self::Empty => "the mask is empty",
            Self::Inverted => "the mask is that of the background, or the object is too near",
            Self::CutOff => "the object is cut off by the image's border",
        }
    }
}

fn sighting(
    folder: &Path,
    name: ImageName,
    table_from_reference: &Pose,
    calibrated: &RigCamera,
) -> Result<Sighting, Unusable> {
    let unreadable = |file: PathBuf| |error: ImportError| Unusable::File(file, error.to_string());
    let (mask_file, image_file) = (folder.join(name.mask()), folder.join(name.image()));
    let mask = read_pbm(&mask_file).map_err(unreadable(mask_file.clone()))?;
    let silhouette = Silhouette::of(&mask).map_err(Unusable::Mask)?;
    let image = read_jpeg(&image_file).map_err(unreadable(image_file.clone()))?;
    if mask.dimensions() != image.dimensions() {
        let reason = format!("{:?} pixels, and the image has {:?}", mask.dimensions(), image.dimensions());
        return Err(Unusable::File(mask_file, reason));
    }
    let camera = calibrated.camera(image.width(), image.height());
    if !principal_point::is_inside(&camera) {
        let got = format!("{} x {} pixels", camera.width, camera.height);
        let expected = format!("the principal point {:.1}, {:.1} in the image", camera.cx, camera.cy);
        let remedy = "take images of the size they were calibrated at";
        return Err(Unusable::Rig(ImportError::invalid(&image_file, "size", got, expected, remedy)));
    }
    let ideal = |pixel: &Vector2<f64>| calibrated.lens.undistort(&camera.ray_in_camera(pixel).xy());
    let center = ideal(&silhouette.mask.bounding_box.center());
    let outline: Option<Vec<Vector2<f64>>> = silhouette.outline.iter().map(ideal).collect();
    let (Some(center), Some(outline)) = (center, outline) else {
        let reason = "the object lies where the lens's distortion cannot be undone";
        return Err(Unusable::File(image_file, reason.to_owned()));
    };
    let labelled = Labelled { width: image.width() as usize, rgb: image.as_raw(), ids: &silhouette.ids };
    let window = Window::around(&silhouette.mask.bounding_box);
    Ok(Sighting {
        name,
        table_from_camera: table_from_reference * calibrated.camera_from_reference.inverse(),
        center,
        outline,
        crop: cut(&labelled, &window, Some(OBJECT)),
    })
}

fn views(
    folder: &Path,
    sightings: &[Sighting],
    upright: UnitQuaternion<f64>,
    instance: usize,
    report: &mut ImportReport,
) -> Vec<View> {
    let rays: Vec<Ray> = sightings.iter().map(Sighting::ray).collect();
    let Some(center) = meeting_point(&rays) else {
        report.skip(folder, format!("{} views do not tell where the object is", sightings.len()));
        return Vec::new();
    };
    let mut radii: Vec<f64> = sightings.iter().map(|sighting| sighting.radius(&center)).collect();
    radii.sort_by(f64::total_cmp);
    let size = 2.0 * radii[((radii.len() - 1) as f64 * RADIUS_QUANTILE).round() as usize];
    let table_from_object = Pose::from_parts(Translation3::from(center), upright);

    let mut views = Vec::new();
    for sighting in sightings {
        let object_from_camera = table_from_object.inv_mul(&sighting.table_from_camera);
        let Some(viewpoint) = Viewpoint::new(&object_from_camera, size) else {
            let reason = "the viewpoint is undefined: from the object's axis, or behind the camera";
            report.skip(folder.join(sighting.name.image()), reason);
            continue;
        };
        let center_in_camera = object_from_camera.inverse().translation.vector;
        let error = sighting.center - center_in_camera.xy() / center_in_camera.z;
        let angular_size = size / center_in_camera.norm();
        views.push(View {
            instance,
            session: 0,
            viewpoint,
            crop: sighting.crop.clone(),
            visible_fraction: 1.0,
            box_center_error: (error / angular_size).into(),
            sighting: None,
        });
    }
    views
}

/// The names in a folder that are text, sorted.
fn names_in(folder: &Path) -> Result<Vec<String>, ImportError> {
    let entries = std::fs::read_dir(folder).map_err(ImportError::read(folder))?;
    let mut names = Vec::new();
    for entry in entries {
        names.extend(entry.map_err(ImportError::read(folder))?.file_name().into_string());
    }
    names.sort();
    Ok(names)
}
