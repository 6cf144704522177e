//! The detector: objects in an image, with their boxes and crops, `Z^g` and `Z^s`.

use crate::error::SimError;
use crate::render::{Frame, RenderScene, Renderer, Shot, TileShot};
use crate::scene::DetectorSpec;
use crate::sensor::{bounds, depth, fault};
use nalgebra::Vector3;
use vantage_dataset::window::{Labelled, MARGIN, Window, cut};
use vantage_dataset::{Detection, DetectionTruth, Mask, Pose, Seed};

/// Side of the tile in which an object's whole silhouette is counted, pixels.
const TILE_SIDE: u32 = 64;

/// Something that can be detected.
#[derive(Clone, Debug)]
pub struct Target {
    /// Where it is.
    pub world_from_object: Pose,
    /// Half the extents of its bounding box, its own frame, metres.
    pub half_extents: Vector3<f64>,
    /// The object and nothing else, to count its silhouette; it has the id that it has in images.
    pub alone: RenderScene,
}

/// Reports the targets in an image, less those that it misses; target `i` has the id `i + 1`. Ordered by track.
pub fn detect(
    spec: &DetectorSpec,
    targets: &[Target],
    step: usize,
    shot: &Shot,
    frame: &Frame,
    renderer: &mut dyn Renderer,
    seed: Seed,
) -> Result<Vec<(Detection, DetectionTruth)>, SimError> {
    let width = frame.width as usize;
    let seen: Vec<(usize, Mask)> = Mask::of_all(&frame.ids, width, targets.len())
        .into_iter()
        .enumerate()
        .filter_map(|(track, mask)| Some((track, mask?)))
        .filter(|(_, mask)| mask.pixels >= spec.min_mask_pixels)
        .filter(|(track, _)| !spec.faults.as_ref().is_some_and(|f| fault::is_missed(f, step, *track, seed)))
        .collect();
    let silhouettes = silhouettes(targets, &seen, shot, renderer)?;
    let image = Labelled { width, rgb: &frame.rgb, ids: &frame.ids };
    Ok(seen
        .iter()
        .zip(silhouettes)
        .map(|((track, mask), silhouette)| (*track, mask, (f64::from(mask.pixels) / silhouette).min(1.0)))
        .filter(|(_, _, visible_fraction)| *visible_fraction >= spec.min_visible_fraction)
        .map(|(track, mask, visible_fraction)| {
            let bounding_box = match &spec.faults {
                Some(faults) => fault::jittered(faults, &mask.bounding_box, fault::number(step, track), seed),
                None => mask.bounding_box,
            };
            let window = Window::around(&bounding_box);
            let camera_from_object = shot.world_from_camera.inv_mul(&targets[track].world_from_object);
            let detection = Detection {
                step,
                track,
                bounding_box,
                mask_pixels: mask.pixels,
                center_depth: depth::measured(spec, &camera_from_object, fault::number(step, track), seed),
                masked_crop: cut(&image, &window, Some(track as u32 + 1)),
                boxed_crop: cut(&image, &window, None),
            };
            (detection, DetectionTruth { visible_fraction })
        })
        .collect())
}

/// Area, pixels of the image, of each seen target's silhouette without occluders or the image's border.
fn silhouettes(
    targets: &[Target],
    seen: &[(usize, Mask)],
    shot: &Shot,
    renderer: &mut dyn Renderer,
) -> Result<Vec<f64>, SimError> {
    let tiles: Vec<TileShot<'_>> = seen
        .iter()
        .map(|(track, _)| {
            let target = &targets[*track];
            let camera_from_object = shot.world_from_camera.inv_mul(&target.world_from_object);
            let bounds = bounds::projected(&shot.camera, &camera_from_object, &target.half_extents);
            TileShot {
                scene: &target.alone,
                shot: *shot,
                center: bounds.center().into(),
                side: MARGIN * bounds.side(),
                target: *track as u32 + 1,
            }
        })
        .collect();
    let rendered = renderer.tiles(&tiles, TILE_SIDE)?;
    Ok(tiles
        .iter()
        .zip(&rendered)
        .map(|(shot, tile)| f64::from(tile.amodal_pixels) * (shot.side / f64::from(TILE_SIDE)).powi(2))
        .collect())
}
