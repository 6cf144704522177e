//! Which pixels of an image are an object's: by mask files, or by drawing the models.

use super::files::{Annotated, Frame};
use super::mesh::{MeshGeometry, ReadModel};
use crate::import::{FETCH_AGAIN, ImportError};
use crate::picture::read_png;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::{Camera, Pose};

const VISIBLE: &str = "mask_visib";

/// What draws models where a dataset has no masks.
pub trait Silhouettes {
    /// The number of the nearest mesh at each pixel, from 1, and 0 where there is none; row-major. Poses are `camera_from_model`.
    ///
    /// # Errors
    ///
    /// What stops the renderer.
    fn ids(&mut self, camera: &Camera, meshes: &[(&MeshGeometry, Pose)]) -> Result<Vec<u32>, String>;
}

/// The visible pixels of each object of an image.
pub(super) struct Visible {
    /// Of each pixel the index of the object in the image's list and one more, or 0.
    pub(super) ids: Vec<u32>,
    /// By the objects of the frame: the visible share; none where neither file nor model tells.
    pub(super) fractions: Vec<Option<f64>>,
}

/// By `mask_visib` where the scene has that folder, and else by models, kept to the boxes of what is visible.
///
/// # Errors
///
/// A mask that is missing or of another size, and a renderer that fails.
pub(super) fn visible(
    scene: &Path,
    frame: &Frame,
    camera: &Camera,
    models: &BTreeMap<u32, ReadModel>,
    silhouettes: &mut dyn Silhouettes,
) -> Result<Visible, ImportError> {
    if scene.join(VISIBLE).is_dir() {
        of_files(scene, frame, camera)
    } else {
        of_models(scene, frame, camera, models, silhouettes)
    }
}

fn of_files(scene: &Path, frame: &Frame, camera: &Camera) -> Result<Visible, ImportError> {
    let mut ids = vec![0; camera.width as usize * camera.height as usize];
    let mut fractions = Vec::new();
    for object in &frame.objects {
        let name = format!("{:06}_{:06}.png", frame.image, object.index);
        let visible = read_mask(&scene.join(VISIBLE).join(&name), camera)?;
        let mut pixels = 0_u32;
        for (id, _) in ids.iter_mut().zip(&visible).filter(|(_, is_visible)| **is_visible) {
            *id = object.index as u32 + 1;
            pixels += 1;
        }
        let whole = || {
            let mask = read_mask(&scene.join("mask").join(&name), camera).ok()?;
            let all = mask.iter().filter(|set| **set).count();
            Some((f64::from(pixels) / all.max(1) as f64).min(1.0))
        };
        fractions.push(object.visible_fraction.or_else(whole));
    }
    Ok(Visible { ids, fractions })
}

fn read_mask(path: &Path, camera: &Camera) -> Result<Vec<bool>, ImportError> {
    let mask = read_png(path)?;
    let (got, expected) = (mask.dimensions(), (camera.width, camera.height));
    if got != expected {
        return Err(ImportError::invalid(
            path,
            "size",
            format!("{got:?}"),
            format!("{expected:?}"),
            FETCH_AGAIN,
        ));
    }
    Ok(mask.as_raw().chunks_exact(3).map(|pixel| pixel[0] > 0).collect())
}

fn of_models(
    scene: &Path,
    frame: &Frame,
    camera: &Camera,
    models: &BTreeMap<u32, ReadModel>,
    silhouettes: &mut dyn Silhouettes,
) -> Result<Visible, ImportError> {
    let mesh = |object: &Annotated| models.get(&object.key.object).and_then(|model| model.mesh.as_ref());
    let drawn: Vec<(&Annotated, (&MeshGeometry, Pose))> = frame
        .objects
        .iter()
        .filter_map(|object| Some((object, (mesh(object)?, object.camera_from_model))))
        .collect();
    let failed = |error: String| {
        let field = format!("image {}", frame.image);
        ImportError::invalid(scene, field, error, "an image that can be drawn", "check cam_K and the models")
    };
    let meshes: Vec<_> = drawn.iter().map(|(_, placed)| *placed).collect();
    let mut ids =
        if meshes.is_empty() { Vec::new() } else { silhouettes.ids(camera, &meshes).map_err(failed)? };
    ids.resize(camera.width as usize * camera.height as usize, 0);
    for (pixel, id) in ids.iter_mut().enumerate().filter(|(_, id)| **id > 0) {
        let object = drawn[*id as usize - 1].0;
        let (x, y) = (pixel % camera.width as usize, pixel / camera.width as usize);
        let (x, y) = (x as f64, y as f64);
        let is_inside = object
            .visible_box
            .is_none_or(|b| (b.min.x..b.max.x).contains(&x) && (b.min.y..b.max.y).contains(&y));
        *id = if is_inside { object.index as u32 + 1 } else { 0 };
    }
    let mut fractions = Vec::new();
    for object in &frame.objects {
        let fraction = match (object.visible_fraction, mesh(object)) {
            (Some(fraction), _) => Some(fraction),
            (None, Some(mesh)) => {
                let alone = silhouettes.ids(camera, &[(mesh, object.camera_from_model)]).map_err(failed)?;
                let count = |ids: &[u32], id: u32| ids.iter().filter(|found| **found == id).count() as f64;
                let all = count(&alone, 1);
                (all > 0.0).then(|| (count(&ids, object.index as u32 + 1) / all).min(1.0))
            }
            (None, None) => None,
        };
        fractions.push(fraction);
    }
    Ok(Visible { ids, fractions })
}
