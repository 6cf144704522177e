//! Renders an object from all round to measure its symmetry. An image difference is a mean over the pixels of either silhouette.

use super::Object;
use crate::render::{Light, Placement, RenderError, RenderScene, Renderer, Shot, Tile, TileShot};
use crate::robot::mount::looking;
use nalgebra::{Translation3, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use vantage_dataset::{Camera, Pose, SelfSimilarity};

/// Azimuths: orders 2 to 6, 8, 10 and 12 turn one into another.
const AZIMUTHS: usize = 120;
/// Side of an image, pixels.
const SIDE: u32 = 64;
/// Of the camera above the horizon, radians.
const ELEVATION: f64 = 20.0 / 180.0 * PI;
/// Of the camera from the object's centre, in the object's diameters.
const DISTANCE: f64 = 4.0;

/// Renders the object from all round under even light, and compares.
pub fn self_similarity(object: &Object, renderer: &mut dyn Renderer) -> Result<SelfSimilarity, RenderError> {
    let placement = Placement { model: Arc::clone(&object.model), world_from_model: Pose::identity(), id: 1 };
    let light = Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
    let scene = RenderScene { placements: vec![placement], light, background: [0; 3] };
    let shots: Vec<TileShot<'_>> = (0..AZIMUTHS).map(|i| tile(&scene, object.size, i)).collect();
    let tiles = renderer.tiles(&shots, SIDE)?;
    let after = |turn: usize| {
        let pairs = (0..AZIMUTHS).map(|i| difference(&tiles[i], &tiles[(i + turn) % AZIMUTHS]));
        pairs.sum::<f64>() / AZIMUTHS as f64
    };
    let half: Vec<f64> = (0..=AZIMUTHS / 2).map(after).collect();
    // Back and forth is the same.
    let differences = (0..AZIMUTHS).map(|turn| Some(half[turn.min(AZIMUTHS - turn)])).collect();
    Ok(SelfSimilarity::new(differences))
}

/// The object filling the image.
fn tile(scene: &RenderScene, size: f64, index: usize) -> TileShot<'_> {
    let azimuth = 2.0 * PI * index as f64 / AZIMUTHS as f64;
    let (across, up) = (libm::cos(ELEVATION), libm::sin(ELEVATION));
    let towards_camera = Vector3::new(across * libm::cos(azimuth), across * libm::sin(azimuth), up);
    let world_from_camera = Pose::from_parts(
        Translation3::from(towards_camera * DISTANCE * size),
        looking(azimuth + PI, -ELEVATION),
    );
    // The sphere about the object is seen under this angle.
    let camera = Camera::with_horizontal_fov(SIDE, SIDE, 2.0 * libm::asin(0.5 / DISTANCE));
    TileShot {
        scene,
        shot: Shot { camera, world_from_camera },
        center: [f64::from(SIDE) / 2.0; 2],
        side: f64::from(SIDE),
        target: 1,
    }
}

fn difference(a: &Tile, b: &Tile) -> f64 {
    let (mut sum, mut pixels) = (0.0, 0usize);
    let (colors_a, colors_b) = (a.rgb.as_chunks::<3>().0, b.rgb.as_chunks::<3>().0);
    for (pixel, (x, y)) in colors_a.iter().zip(colors_b).enumerate() {
        if a.ids[pixel] == 1 || b.ids[pixel] == 1 {
            pixels += 1;
            sum += x.iter().zip(y).map(|(x, y)| f64::from(x.abs_diff(*y))).sum::<f64>();
        }
    }
    sum / (3 * 255 * pixels.max(1)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::reference::ReferenceRenderer;
    use crate::scene::Family;
    use vantage_dataset::{Seed, Split};

    #[test]
    fn families_have_the_symmetry_that_they_state() {
        for family in Family::ALL {
            for index in 0..2 {
                let object = Object::generate(family, Split::Validation, Seed(3), index);
                let turns = self_similarity(&object, &mut ReferenceRenderer::default()).unwrap();
                let alike = turns.most_alike();
                println!(
                    "{} {index}: contrast {:.3}, order {alike} leaves {:.2}, {:?}",
                    family.name(),
                    turns.contrast(),
                    turns.left_over(alike).unwrap(),
                    turns.symmetry()
                );
                assert_eq!(turns.symmetry(), object.symmetry, "{} {index}", family.name());
            }
        }
    }
}
