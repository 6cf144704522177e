//! The families: what all their instances share.
//!
//! A family fixes a layout in a canonical frame (z up, front = +x, left = +y): where the label, the handle, the
//! spout or the face is. Instances differ in proportions, colours, patterns and marks, and the layout itself varies
//! by modest amounts, so that a viewpoint can be read off an instance that was never seen. Only composites have none.

mod book;
mod bottle;
mod bowl;
mod can;
mod carton;
mod composite;
mod crate_box;
mod desk_lamp;
mod duck;
mod figurine;
mod mug;
mod shoe;
mod spray_bottle;
mod teapot;
mod toy_car;
mod toy_house;
mod vase;

use super::paint::{Canvas, Region};
use super::solid::Solid;
use crate::scene::Family;
use vantage_dataset::Stream;

impl Family {
    /// Draws an instance: proportions from `shape`, colours and marks from `look`.
    pub(crate) fn draft(self, shape: &mut Stream, look: &mut Stream) -> Draft {
        let draft = match self {
            Family::Carton => carton::draft,
            Family::Can => can::draft,
            Family::Bottle => bottle::draft,
            Family::Mug => mug::draft,
            Family::Bowl => bowl::draft,
            Family::Book => book::draft,
            Family::ToyCar => toy_car::draft,
            Family::ToyHouse => toy_house::draft,
            Family::Figurine => figurine::draft,
            Family::Teapot => teapot::draft,
            Family::Crate => crate_box::draft,
            Family::Vase => vase::draft,
            Family::SprayBottle => spray_bottle::draft,
            Family::Shoe => shoe::draft,
            Family::DeskLamp => desk_lamp::draft,
            Family::Duck => duck::draft,
            Family::Composite => composite::draft,
        };
        draft(shape, look)
    }
}

/// An instance before it is centred and hashed.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    pub solid: Solid,
    pub canvas: Canvas,
    /// Mass over the volume that the surface encloses, kg/m^3.
    pub density: f64,
}

/// The texture of a family with one wrapped surface: the wrap, a square, four spots.
const WRAP: Region = Region::new(0, 0, 128, 80);
const SQUARE: Region = Region::new(0, 80, 48, 48);
const SPOTS: [Region; 4] = [
    Region::new(48, 80, 40, 24),
    Region::new(88, 80, 40, 24),
    Region::new(48, 104, 40, 24),
    Region::new(88, 104, 40, 24),
];
