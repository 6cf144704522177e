//! Whole images with the silhouettes of what they show.

use crate::error::SimError;
use crate::observer::{Look, Observer};
use crate::render::{MAX_SIDE, Renderer, Shot};
use crate::sensor::bounds;
use crate::sensor::detector::Target;
use nalgebra::Vector2;
use vantage_dataset::Mask;
use vantage_dataset::{BoundingBox, Camera, Capture, CapturedObject};

/// Completes a look: each object of which a pixel is visible is drawn once more, alone.
pub fn capture(
    observer: &Observer<'_>,
    look: &Look,
    timestamp: f64,
    renderer: &mut dyn Renderer,
) -> Result<Capture, SimError> {
    let frame = &look.frame;
    let masks = Mask::of_all(&frame.ids, frame.width as usize, observer.targets().len());
    let mut objects = Vec::new();
    for (track, (target, mask)) in observer.targets().iter().zip(masks).enumerate() {
        let Some(mask) = mask else { continue };
        objects.push(silhouette(track, target, &mask, &look.shot, renderer)?);
    }
    Ok(Capture {
        timestamp,
        camera: look.shot.camera,
        world_from_camera: look.shot.world_from_camera,
        rgb: frame.rgb.clone(),
        depth: frame.depth.clone(),
        ids: frame.ids.clone(),
        objects,
    })
}

/// Draws the object alone, on a canvas of twice the image's size where it may reach beyond it; what lies even further out is
/// not counted.
fn silhouette(
    track: usize,
    target: &Target,
    mask: &Mask,
    shot: &Shot,
    renderer: &mut dyn Renderer,
) -> Result<CapturedObject, SimError> {
    let camera = shot.camera;
    let camera_from_object = shot.world_from_camera.inv_mul(&target.world_from_object);
    let reach = bounds::projected(&camera, &camera_from_object, &target.half_extents);
    let beside = |side: u32| (side / 2).min((MAX_SIDE - side.min(MAX_SIDE)) / 2);
    let border =
        if reach.is_truncated(&camera) { [beside(camera.width), beside(camera.height)] } else { [0, 0] };
    let canvas = Camera {
        width: camera.width + 2 * border[0],
        height: camera.height + 2 * border[1],
        cx: camera.cx + f64::from(border[0]),
        cy: camera.cy + f64::from(border[1]),
        ..camera
    };
    let alone =
        renderer.frame(&target.alone, &Shot { camera: canvas, world_from_camera: shot.world_from_camera })?;
    let id = track as u32 + 1;
    // Seen behind others, it is seen alone: only rounding at its edge could say otherwise.
    let whole = Mask::of(&alone.ids, canvas.width as usize, id).unwrap_or(*mask);
    let offset = Vector2::new(f64::from(border[0]), f64::from(border[1]));
    let rows = alone.ids.chunks_exact(canvas.width as usize).skip(border[1] as usize);
    let inside = rows
        .take(camera.height as usize)
        .flat_map(|row| row[border[0] as usize..][..camera.width as usize].iter().map(|found| *found == id));
    Ok(CapturedObject {
        track,
        visible_box: mask.bounding_box,
        visible_pixels: mask.pixels,
        silhouette_box: BoundingBox {
            min: whole.bounding_box.min - offset,
            max: whole.bounding_box.max - offset,
        },
        silhouette_pixels: f64::from(whole.pixels.max(mask.pixels)),
        silhouette: inside.collect(),
    })
}
