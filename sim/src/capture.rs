//! Whole images with the silhouettes of what they show.

use crate::error::SimError;
use crate::observer::{Look, Observer};
use crate::render::{Renderer, Shot};
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

/// Draws the object alone, in the image and in those images beside it that it may reach into, as BOP's toolkit does on a canvas
/// of three times the image's width and height; what lies even further out is not counted.
fn silhouette(
    track: usize,
    target: &Target,
    mask: &Mask,
    shot: &Shot,
    renderer: &mut dyn Renderer,
) -> Result<CapturedObject, SimError> {
    let Camera { width, cx, cy, .. } = shot.camera;
    let id = track as u32 + 1;
    let alone = renderer.frame(&target.alone, shot)?;
    // Seen behind others, it is seen alone: only rounding at its edge could say otherwise.
    let mut whole = Mask::of(&alone.ids, width as usize, id).unwrap_or(*mask);
    for corner in images_beside(target, shot) {
        let camera = Camera { cx: cx - corner.x, cy: cy - corner.y, ..shot.camera };
        let frame = renderer.frame(&target.alone, &Shot { camera, ..*shot })?;
        let Some(part) = Mask::of(&frame.ids, width as usize, id) else { continue };
        whole.pixels += part.pixels;
        whole.bounding_box = BoundingBox {
            min: whole.bounding_box.min.inf(&(part.bounding_box.min + corner)),
            max: whole.bounding_box.max.sup(&(part.bounding_box.max + corner)),
        };
    }
    Ok(CapturedObject {
        track,
        visible_box: mask.bounding_box,
        visible_pixels: mask.pixels,
        silhouette_box: whole.bounding_box,
        silhouette_pixels: f64::from(whole.pixels.max(mask.pixels)),
        silhouette: alone.ids.iter().map(|found| *found == id).collect(),
    })
}

/// The upper left corners, pixels of the shot, of those of the eight images around it that an object may reach into.
fn images_beside(target: &Target, shot: &Shot) -> Vec<Vector2<f64>> {
    let camera_from_object = shot.world_from_camera.inv_mul(&target.world_from_object);
    let reach = bounds::projected(&shot.camera, &camera_from_object, &target.half_extents);
    // A corner behind the camera has no pixel, and `reach` leaves it out.
    let anywhere = camera_from_object.translation.z <= target.half_extents.norm();
    let size = Vector2::new(f64::from(shot.camera.width), f64::from(shot.camera.height));
    let reaches = |corner: &Vector2<f64>| {
        let end = corner + size;
        (0..2).all(|axis| reach.min[axis] < end[axis] && reach.max[axis] > corner[axis])
    };
    let steps = [-1.0, 0.0, 1.0];
    let corners = steps.iter().flat_map(|y| steps.map(|x| size.component_mul(&Vector2::new(x, *y))));
    corners.filter(|corner| corner.norm() > 0.0 && (anywhere || reaches(corner))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::model::Model;
    use crate::render::reference::ReferenceRenderer;
    use crate::render::{Light, Placement, RenderScene};
    use crate::texture::{TEXTURE_SIDE, Texture};
    use nalgebra::Vector3;
    use std::sync::Arc;
    use vantage_dataset::Pose;

    const SIDE: u32 = 100;

    /// An upright square from the pixel `left` to `right`, 1 m before the camera, of which 100 pixels are 1 m.
    fn square(left: f32, right: f32) -> Target {
        let half = (right - left) / 200.0;
        let mesh = Mesh {
            positions: vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]],
            normals: vec![[0.0, 0.0, -1.0]; 4],
            uvs: vec![[0.0; 2]; 4],
            triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 2], [0, 2, 3]],
        };
        let texture = Texture::new(vec![[255; 4]; TEXTURE_SIDE * TEXTURE_SIDE]);
        let world_from_model = Pose::translation(f64::from(left + right) / 200.0 - 0.5, 0.0, 1.0);
        let model = Arc::new(Model::new(mesh, texture));
        let light = Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
        Target {
            world_from_object: world_from_model,
            half_extents: Vector3::new(half.into(), half.into(), 0.0),
            alone: RenderScene {
                placements: vec![Placement { model, world_from_model, id: 1 }],
                light,
                background: [0; 3],
            },
        }
    }

    /// First and last column, exclusive, of the whole silhouette, its pixels, and those in the image.
    fn drawn(left: f32, right: f32) -> (f64, f64, f64, usize) {
        let camera = Camera { width: SIDE, height: SIDE, fx: 100.0, fy: 100.0, cx: 50.0, cy: 50.0 };
        let shot = Shot { camera, world_from_camera: Pose::identity() };
        let anything = Mask {
            bounding_box: BoundingBox { min: Vector2::zeros(), max: Vector2::repeat(1.0) },
            pixels: 1,
        };
        let target = square(left, right);
        let object = silhouette(0, &target, &anything, &shot, &mut ReferenceRenderer::default()).unwrap();
        let inside = object.silhouette.iter().filter(|inside| **inside).count();
        (object.silhouette_box.min.x, object.silhouette_box.max.x, object.silhouette_pixels, inside)
    }

    #[test]
    fn silhouettes_are_counted_as_far_as_one_image_beyond_each_border() {
        assert_eq!(drawn(20.0, 80.0), (20.0, 80.0, 3600.0, 3600));
        assert_eq!(drawn(90.0, 190.0), (90.0, 190.0, 10_000.0, 1000));
        assert_eq!(drawn(-90.0, 10.0), (-90.0, 10.0, 10_000.0, 1000));
        assert_eq!(drawn(-20.0, 120.0), (-20.0, 120.0, 19_600.0, 10_000));
        assert_eq!(drawn(90.0, 250.0), (90.0, 200.0, 110.0 * 160.0, 1000));
    }
}
