//! How the look of an object changes as it turns about the vertical: its symmetry, measured.
//!
//! ```text
//! D(t) = mean over a of |I(a) - I(a + t)|       I(a): image from the azimuth a, 0 to 1, black around the object
//! contrast = mean over t of D(t)                left over at order n = max over k of D(2 pi k / n) / contrast
//! ```
//!
//! The mean of an image difference is over the pixels of either silhouette.

use super::Object;
use crate::render::{Light, Placement, RenderError, RenderScene, Renderer, Shot, Tile, TileShot};
use crate::robot::mount::looking;
use nalgebra::{Translation3, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use vantage_dataset::{Camera, Pose, Symmetry};

/// Azimuths: orders 2 to 6, 8, 10 and 12 turn one into another.
const AZIMUTHS: usize = 120;
/// Orders that are looked for.
const ORDERS: [u8; 8] = [2, 3, 4, 5, 6, 8, 10, 12];
/// Side of an image, pixels.
const SIDE: u32 = 64;
/// Of the camera above the horizon, radians.
const ELEVATION: f64 = 20.0 / 180.0 * PI;
/// Of the camera from the object's centre, in the object's diameters.
const DISTANCE: f64 = 4.0;
/// An order is one of the object's if no more than this is left over.
const ALIKE: f64 = 0.25;
/// Of less contrast all turns look alike.
const FAINT: f64 = 0.04;

/// Differences between the looks of an object before and after turns about the vertical.
#[derive(Clone, Debug, PartialEq)]
pub struct Turns {
    /// After as many 120ths of a turn as the index says: of the greatest difference there can be.
    differences: Vec<f64>,
}

impl Turns {
    /// Renders the object from all round under even light.
    pub fn of(object: &Object, renderer: &mut dyn Renderer) -> Result<Self, RenderError> {
        let placement =
            Placement { model: Arc::clone(&object.model), world_from_model: Pose::identity(), id: 1 };
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
        let differences = (0..AZIMUTHS).map(|turn| half[turn.min(AZIMUTHS - turn)]).collect();
        Ok(Self { differences })
    }

    /// Mean difference over all turns, as a share of the greatest there can be.
    pub fn contrast(&self) -> f64 {
        self.differences.iter().sum::<f64>() / (AZIMUTHS - 1) as f64
    }

    /// Greatest difference after turns of which `order` make a full one, as a share of the contrast; 0 of what looks the same from all round.
    pub fn left_over(&self, order: u8) -> f64 {
        let turn = AZIMUTHS / usize::from(order);
        let greatest = self.differences.iter().step_by(turn).fold(0.0, |a: f64, b| a.max(*b));
        if greatest > 0.0 { greatest / self.contrast() } else { 0.0 }
    }

    /// The order of the symmetry, where it has one; else that which leaves the least over, of those that are looked for.
    pub fn most_alike(&self) -> u8 {
        if let Symmetry::Cyclic { order } = self.symmetry() {
            return order;
        }
        let by_left_over = |a: &u8, b: &u8| self.left_over(*a).total_cmp(&self.left_over(*b));
        ORDERS.into_iter().min_by(by_left_over).unwrap_or(ORDERS[0])
    }

    /// The greatest order that leaves little over.
    pub fn symmetry(&self) -> Symmetry {
        if self.contrast() < FAINT {
            return Symmetry::Revolution;
        }
        let greatest = ORDERS.into_iter().rev().find(|order| self.left_over(*order) < ALIKE);
        greatest.map_or(Symmetry::None, |order| Symmetry::Cyclic { order })
    }
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
                let turns = Turns::of(&object, &mut ReferenceRenderer::default()).unwrap();
                let alike = turns.most_alike();
                println!(
                    "{} {index}: contrast {:.3}, order {alike} leaves {:.2}, {:?}",
                    family.name(),
                    turns.contrast(),
                    turns.left_over(alike),
                    turns.symmetry()
                );
                assert_eq!(turns.symmetry(), object.symmetry, "{} {index}", family.name());
            }
        }
    }
}
