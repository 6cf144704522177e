//! Photographs of objects from known azimuths, by the names of their files, as COIL-100 (Nene et al. 1996) has them.
//!
//! `OBJECT__AZIMUTH.png` or `.jpg`, the azimuth in degrees; `OBJECT__AZIMUTH_mask.png` beside it, where there is one, is not 0 where the
//! object is. Without one the photograph is dark around it. Files in the folder itself are one session, those of each folder in it another.

use crate::import::{ImportError, ImportReport};
use crate::picture::{read_jpeg, read_png};
use image::RgbImage;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vantage_dataset::views::InstanceRecord;
use vantage_dataset::window::{Labelled, Window, cut};
use vantage_dataset::{Crop, InstanceId, Mask, SelfSimilarity, Split, Symmetry, View, ViewSet, Viewpoint};

/// A pixel without a mask is the object's where a channel is above the darkest corner by more.
const BRIGHTER: u8 = 24;
/// A darkest corner that is brighter is no dark background.
const DARK: u8 = 64;
const MASK: &str = "_mask";
/// Endings of files that would be photographs under another name.
const IMAGES: [&str; 8] = ["png", "jpg", "jpeg", "tif", "tiff", "bmp", "webp", "gif"];

/// What file names do not say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turntable {
    /// Elevation of the camera, radians.
    pub elevation: f64,
    /// Distance of the camera over the object's size.
    pub distance: f64,
    /// Whether azimuths grow clockwise, seen from above.
    pub clockwise: bool,
}

/// One photograph.
struct Photo {
    session: usize,
    /// Radians, as the name says.
    azimuth: f64,
    path: PathBuf,
    mask: Option<PathBuf>,
}

/// Reads the views of the objects that `takes` says, ordered by object, session, azimuth.
///
/// What does not decode, shows no object, or has another name is left out and reported, as are folders inside those of sessions.
///
/// # Errors
///
/// A folder that cannot be read, and one object at one azimuth twice in a session, modulo a turn.
pub fn read_turned_photos(
    root: &Path,
    split: Split,
    turntable: &Turntable,
    takes: &dyn Fn(&str) -> bool,
) -> Result<(ViewSet, ImportReport), ImportError> {
    let mut set = ViewSet { split, instances: Vec::new(), views: Vec::new() };
    let mut report = ImportReport::default();
    for (name, photos) in photos(root, &mut report)?.into_iter().filter(|(name, _)| takes(name)) {
        let instance = set.instances.len();
        let first = set.views.len();
        for Photo { session, azimuth, path, mask } in photos {
            let crop = match crop(&path, mask.as_deref()) {
                Ok(Some(crop)) => crop,
                Ok(None) => {
                    report.skip(path, "no pixel is the object's");
                    continue;
                }
                Err(error) => {
                    report.skip(path, error);
                    continue;
                }
            };
            let viewpoint = turntable.viewpoint(azimuth);
            set.views.push(View {
                instance,
                session,
                viewpoint,
                crop,
                visible_fraction: 1.0,
                box_center_error: [0.0; 2],
                sighting: None,
            });
        }
        if set.views.len() > first {
            let id = InstanceId::of_name(&name);
            set.instances.push(InstanceRecord { id, family: name, symmetry: symmetry(&set.views[first..]) });
        }
    }
    report.views = set.views.len();
    Ok((set, report))
}

/// By the first session, as another light is another look.
fn symmetry(views: &[View]) -> Symmetry {
    let of_first = views.iter().filter(|view| view.session == views[0].session);
    let crops: Vec<(f64, &Crop)> = of_first.map(|view| (view.viewpoint.azimuth(), &view.crop)).collect();
    SelfSimilarity::of_crops(&crops).map_or(Symmetry::None, |similarity| similarity.symmetry())
}

impl Turntable {
    fn viewpoint(&self, azimuth: f64) -> Viewpoint {
        let azimuth = if self.clockwise { -azimuth } else { azimuth };
        let ((sin, cos), (up, out)) = (libm::sincos(azimuth), libm::sincos(self.elevation));
        Viewpoint {
            direction: Vector3::new(out * cos, out * sin, up),
            roll: 0.0,
            log_distance: libm::log(self.distance),
        }
    }
}

/// The photographs of each object by name, by session and azimuth.
fn photos(root: &Path, report: &mut ImportReport) -> Result<BTreeMap<String, Vec<Photo>>, ImportError> {
    let mut folders = vec![root.to_owned()];
    folders.extend(entries(root)?.into_iter().filter(|path| path.is_dir()));
    let mut found: BTreeMap<String, Vec<Photo>> = BTreeMap::new();
    for (session, folder) in folders.iter().enumerate() {
        let files = files(folder, session > 0, report)?;
        let mut masks: BTreeMap<String, &PathBuf> = BTreeMap::new();
        let mut others = Vec::new();
        for path in &files {
            match masked(path) {
                Some(of) if ending(path) == "png" => {
                    masks.insert(of, path);
                }
                Some(_) if is_image(path) => {
                    report.skip(path, "is a mask that is no PNG, and is not read; save it as PNG");
                }
                _ => others.push(path),
            }
        }
        for path in others {
            let Some((name, degrees)) = named(path) else {
                if is_image(path) {
                    report.skip(path, "is not named OBJECT__AZIMUTH.png or .jpg, such as cup__30.png");
                }
                continue;
            };
            let mask = masks.remove(&stem(path)).cloned();
            let turned = degrees.rem_euclid(360.0);
            let (azimuth, own) = (turned.to_radians(), found.entry(name.clone()).or_default());
            if own.iter().any(|other| other.session == session && other.azimuth == azimuth) {
                let (got, expected) = (format!("{name} at {turned} degrees twice"), "each azimuth once");
                let remedy = "leave out one of the files, or put it into a folder of its own";
                return Err(ImportError::invalid(path, "name", got, expected, remedy));
            }
            own.push(Photo { session, azimuth, path: path.clone(), mask });
        }
        for mask in masks.into_values() {
            report.skip(mask, "is the mask of no photograph");
        }
    }
    for photos in found.values_mut() {
        photos.sort_by(|a, b| a.session.cmp(&b.session).then(a.azimuth.total_cmp(&b.azimuth)));
    }
    Ok(found)
}

/// The files of a session, without images that have unfit names.
fn files(
    folder: &Path,
    has_own_folder: bool,
    report: &mut ImportReport,
) -> Result<Vec<PathBuf>, ImportError> {
    let (folders, mut files): (Vec<PathBuf>, Vec<PathBuf>) =
        entries(folder)?.into_iter().partition(|path| path.is_dir());
    if let Some(first) = folders.first().filter(|_| has_own_folder) {
        let count = folders.len();
        let reason = format!(
            "folders inside a session's folder are not read ({count} here, the first is named); move them beside it"
        );
        report.skip(first, reason);
    }
    files.retain(|path| {
        let unfit = unfit_name(path);
        // The reason names the file, as its path would break the line.
        if let Some(reason) = &unfit {
            report.skip(folder, reason);
        }
        unfit.is_none()
    });
    Ok(files)
}

/// Why an image cannot have an object's name: stored names are of one line, without control characters.
fn unfit_name(path: &Path) -> Option<String> {
    let name = path.file_name().unwrap_or_default();
    let is_unfit = name.to_str().is_none_or(|text| text.contains(char::is_control));
    (is_unfit && is_image(path))
        .then(|| format!("the file name {name:?} is not UTF-8 or has control characters; rename the file"))
}

/// The stem of the photograph whose mask has this name; `None` of any other file.
fn masked(path: &Path) -> Option<String> {
    let stem = stem(path);
    // By bytes, as letters may change their length with their case.
    let cut = stem.len().checked_sub(MASK.len()).filter(|&cut| stem.is_char_boundary(cut))?;
    let (of, end) = stem.split_at(cut);
    end.eq_ignore_ascii_case(MASK).then(|| of.to_owned())
}

/// Object and azimuth, degrees; `None` of any other file.
fn named(path: &Path) -> Option<(String, f64)> {
    let stem = stem(path);
    let (object, degrees) = stem.rsplit_once("__")?;
    let degrees = degrees.parse::<f64>().ok().filter(|degrees| degrees.is_finite())?;
    let is_photo = matches!(ending(path).as_str(), "png" | "jpg" | "jpeg");
    (is_photo && !object.is_empty()).then(|| (object.to_owned(), degrees))
}

fn is_image(path: &Path) -> bool {
    IMAGES.contains(&ending(path).as_str())
}

/// In small letters, without the dot.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let read = || -> std::io::Result<Vec<PathBuf>> {
        let mut paths: Vec<PathBuf> =
            std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
        paths.retain(|path| !stem(path).starts_with('.'));
        paths.sort();
        Ok(paths)
    };
    read().map_err(ImportError::read(folder))
}

/// The crop of a photograph; `None` where no pixel is the object's.
fn crop(path: &Path, mask: Option<&Path>) -> Result<Option<Crop>, ImportError> {
    let image = if ending(path) == "png" { read_png(path)? } else { read_jpeg(path)? };
    let ids = match mask {
        None => of_brightness(path, &image)?,
        Some(file) => of_mask(file, &image)?,
    };
    let Some(silhouette) = Mask::of(&ids, image.width() as usize, 1) else { return Ok(None) };
    let labelled = Labelled { width: image.width() as usize, rgb: image.as_raw(), ids: &ids };
    let window = Window::around(&silhouette.bounding_box);
    Ok(Some(cut(&labelled, &window, Some(1))))
}

/// 1 where a channel is brighter than the darkest corner, as a photographed background is dark, not black.
fn of_brightness(file: &Path, image: &RgbImage) -> Result<Vec<u32>, ImportError> {
    let brightness = |pixel: &[u8]| pixel.iter().copied().max().unwrap_or(0);
    let (right, bottom) = (image.width().saturating_sub(1), image.height().saturating_sub(1));
    let corners = [(0, 0), (right, 0), (0, bottom), (right, bottom)];
    let darkest = corners.iter().map(|&(x, y)| brightness(&image.get_pixel(x, y).0)).min().unwrap_or(0);
    if darkest > DARK {
        let expected = format!("at most {DARK} of 255 in the darkest corner");
        let remedy = "put a mask beside the photograph, or make it black around the object";
        return Err(ImportError::invalid(file, "background", darkest, expected, remedy));
    }
    let brighter = |&(x, y): &(u32, u32)| brightness(&image.get_pixel(x, y).0) - darkest > BRIGHTER;
    if corners.iter().filter(|corner| brighter(corner)).count() > corners.len() / 2 {
        let expected = format!("two corners within {BRIGHTER} of 255 of the darkest, {darkest}");
        let remedy = "put a mask beside the photograph, or make it black around the object";
        return Err(ImportError::invalid(file, "background", "one dark corner", expected, remedy));
    }
    let is_object = |pixel: &[u8]| u32::from(brightness(pixel).saturating_sub(darkest) > BRIGHTER);
    Ok(image.as_raw().chunks_exact(3).map(is_object).collect())
}

fn of_mask(file: &Path, image: &RgbImage) -> Result<Vec<u32>, ImportError> {
    let mask = read_png(file)?;
    if mask.dimensions() != image.dimensions() {
        let (got, expected) = (format!("{:?}", mask.dimensions()), format!("{:?}", image.dimensions()));
        return Err(ImportError::invalid(file, "size", got, expected, "make the mask as large as its image"));
    }
    let inside = |pixel: &[u8]| u32::from(pixel.iter().any(|&value| value > 0));
    Ok(mask.as_raw().chunks_exact(3).map(inside).collect())
}

#[cfg(test)]
mod tests;
