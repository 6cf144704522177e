//! Detections of single objects without whole images: each from a tile that the object fills, as training views are.

use crate::error::SimError;
use crate::render::{NO_OBJECT, RenderScene, Renderer, Shot, Tile, TileShot};
use crate::scene::SensorSpec;
use crate::sensor::detector::Target;
use crate::sensor::{bounds, depth, fault, image};
use nalgebra::Vector2;
use rayon::prelude::*;
use vantage_dataset::Mask;
use vantage_dataset::window::{Labelled, MARGIN, Window, cut};
use vantage_dataset::{BoundingBox, Detection, DetectionTruth, Seed};

/// Side of a tile, pixels.
const TILE_SIDE: u32 = 64;
/// Tiles a renderer gets in one call.
const BATCH: usize = 256;
/// The object's id, and its track.
const TARGET: (u32, usize) = (1, 0);

/// What is drawn at a step.
pub struct Setting {
    /// Everything, the object included.
    pub scene: RenderScene,
    /// Where from.
    pub shot: Shot,
}

/// Reports the one target at each of so many steps at which enough of it is seen; it has the id 1 in every setting. Boxes are as
/// exact as tiles are, to a 64th of their side. What lies beyond the image's border is neither seen nor in a crop, and there are no
/// detections of nothing.
pub fn detect(
    spec: &SensorSpec,
    target: &Target,
    steps: usize,
    setting: impl Fn(usize) -> Setting,
    renderer: &mut dyn Renderer,
    seed: Seed,
) -> Result<Vec<(Detection, DetectionTruth)>, SimError> {
    let mut seen = Vec::with_capacity(steps);
    for first in (0..steps).step_by(BATCH) {
        let settings: Vec<Setting> = (first..steps.min(first + BATCH)).map(&setting).collect();
        let shots: Vec<TileShot<'_>> = settings.iter().map(|setting| tile_of(target, setting)).collect();
        let tiles = renderer.tiles(&shots, TILE_SIDE)?;
        let detections: Vec<Option<(Detection, DetectionTruth)>> = shots
            .par_iter()
            .zip(tiles)
            .enumerate()
            .map(|(i, (shot, tile))| report(spec, target, first + i, shot, tile, seed))
            .collect();
        seen.extend(detections.into_iter().flatten());
    }
    Ok(seen)
}

fn tile_of<'a>(target: &Target, setting: &'a Setting) -> TileShot<'a> {
    let camera_from_object = setting.shot.world_from_camera.inv_mul(&target.world_from_object);
    let bounds = bounds::projected(&setting.shot.camera, &camera_from_object, &target.half_extents);
    TileShot {
        scene: &setting.scene,
        shot: setting.shot,
        center: bounds.center().into(),
        side: (MARGIN * bounds.side() + 2.0).max(f64::from(TILE_SIDE)),
        target: TARGET.0,
    }
}

/// Blackens what lies beyond the image's border.
fn cut_off(shot: &TileShot<'_>, tile: &mut Tile) {
    let side = tile.side as usize;
    let inside = |axis: usize, pixel: usize, pixels: u32| {
        let place = shot.center[axis] + ((pixel as f64 + 0.5) / side as f64 - 0.5) * shot.side;
        (0.0..f64::from(pixels)).contains(&place)
    };
    let columns: Vec<bool> = (0..side).map(|column| inside(0, column, shot.shot.camera.width)).collect();
    let rows = tile.rgb.chunks_exact_mut(3 * side).zip(tile.ids.chunks_exact_mut(side));
    for (row, (rgb, ids)) in rows.enumerate() {
        let row_inside = inside(1, row, shot.shot.camera.height);
        for ((pixel, id), column_inside) in rgb.chunks_exact_mut(3).zip(ids).zip(&columns) {
            if !(row_inside && *column_inside) {
                pixel.fill(0);
                *id = NO_OBJECT;
            }
        }
    }
}

fn report(
    spec: &SensorSpec,
    target: &Target,
    step: usize,
    shot: &TileShot<'_>,
    mut tile: Tile,
    seed: Seed,
) -> Option<(Detection, DetectionTruth)> {
    let detector = &spec.detector;
    cut_off(shot, &mut tile);
    let mask = Mask::of(&tile.ids, TILE_SIDE as usize, TARGET.0)?;
    let scale = shot.side / f64::from(TILE_SIDE);
    let visible_fraction = (f64::from(mask.pixels) / f64::from(tile.amodal_pixels)).min(1.0);
    let pixels = f64::from(mask.pixels) * scale * scale;
    let missed = detector.faults.as_ref().is_some_and(|f| fault::is_missed(f, step, TARGET.1, seed));
    if missed
        || visible_fraction < detector.min_visible_fraction
        || pixels < f64::from(detector.min_mask_pixels)
    {
        return None;
    }
    if let Some(spec) = &spec.camera.image {
        image::degrade(spec, &mut tile.rgb, TILE_SIDE as usize, scale, seed, step as u64);
    }
    let in_tile = match &detector.faults {
        Some(faults) => fault::jittered(faults, &mask.bounding_box, fault::number(step, TARGET.1), seed),
        None => mask.bounding_box,
    };
    let corner = Vector2::from(shot.center).add_scalar(-shot.side / 2.0);
    let drawn = Labelled { width: TILE_SIDE as usize, rgb: &tile.rgb, ids: &tile.ids };
    let window = Window::around(&in_tile);
    let camera_from_object = shot.shot.world_from_camera.inv_mul(&target.world_from_object);
    let detection = Detection {
        step,
        track: TARGET.1,
        bounding_box: BoundingBox { min: corner + in_tile.min * scale, max: corner + in_tile.max * scale },
        mask_pixels: pixels.round() as u32,
        center_depth: depth::measured(detector, &camera_from_object, fault::number(step, TARGET.1), seed),
        masked_crop: cut(&drawn, &window, Some(TARGET.0)),
        boxed_crop: cut(&drawn, &window, None),
    };
    Some((detection, DetectionTruth { visible_fraction }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Light;
    use nalgebra::Vector3;
    use vantage_dataset::{Camera, Pose};

    #[test]
    fn the_border_of_the_image_hides_what_is_beyond() {
        let light = Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
        let scene = RenderScene { placements: Vec::new(), light, background: [0; 3] };
        let shot =
            Shot { camera: Camera::with_horizontal_fov(160, 120, 1.0), world_from_camera: Pose::identity() };
        let cases = [
            ([80.0, 60.0], 64.0, [0, 0], [64, 64]),
            ([0.0, 60.0], 64.0, [32, 0], [64, 64]),
            ([160.0, 120.0], 128.0, [0, 0], [32, 32]),
            ([8.0, -8.0], 64.0, [24, 40], [64, 64]),
        ];
        for (center, side, min, max) in cases {
            let shot = TileShot { scene: &scene, shot, center, side, target: TARGET.0 };
            let pixels = (TILE_SIDE * TILE_SIDE) as usize;
            let mut tile = Tile {
                side: TILE_SIDE,
                rgb: vec![200; 3 * pixels],
                ids: vec![TARGET.0; pixels],
                amodal_pixels: pixels as u32,
            };
            cut_off(&shot, &mut tile);
            for (i, id) in tile.ids.iter().enumerate() {
                let (row, column) = (i / TILE_SIDE as usize, i % TILE_SIDE as usize);
                let seen = (min[0]..max[0]).contains(&column) && (min[1]..max[1]).contains(&row);
                assert_eq!(*id == TARGET.0, seen, "({column}, {row}) around {center:?}");
                assert_eq!(tile.rgb[3 * i] == 200, seen, "({column}, {row}) around {center:?}");
            }
            assert_eq!(tile.amodal_pixels, pixels as u32);
        }
    }
}
