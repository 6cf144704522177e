//! The families: what all their instances share.
//!
//! A family fixes a layout in a canonical frame (z up, front = +x, left = +y): where the label, the handle, the
//! spout or the face is. Instances differ in proportions, colours, patterns and marks, and the layout itself varies
//! by modest amounts, so that a viewpoint can be read off an instance that was never seen.

mod book;
mod bottle;
mod bowl;
mod can;
mod carton;
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
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::{Stream, Symmetry};

/// A kind of object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// A drink carton with a gable top, its cap on the front slope.
    Carton,
    /// A can with a label around it.
    Can,
    /// A flattened bottle with a label and a flip cap that opens to the front.
    Bottle,
    /// A mug, its handle on the left.
    Mug,
    /// A bowl with a pouring lip in front and a grip behind.
    Bowl,
    /// A book lying on its back cover, its spine on the right.
    Book,
    /// A car.
    ToyCar,
    /// A house with a door in front and a chimney at the back left.
    ToyHouse,
    /// A doll with a face, a backpack and a ball in its right hand.
    Figurine,
    /// A pot with its spout in front and its handle behind.
    Teapot,
    /// A chest with four equal sides.
    Crate,
    /// A surface of revolution with rings only.
    Vase,
    /// A bottle with a trigger head that points to the front.
    SprayBottle,
    /// A shoe, its toe in front.
    Shoe,
    /// A lamp that shines to the front.
    DeskLamp,
    /// A bath duck.
    Duck,
}

impl Family {
    /// All families.
    pub const ALL: [Family; 16] = [
        Family::Carton,
        Family::Can,
        Family::Bottle,
        Family::Mug,
        Family::Bowl,
        Family::Book,
        Family::ToyCar,
        Family::ToyHouse,
        Family::Figurine,
        Family::Teapot,
        Family::Crate,
        Family::Vase,
        Family::SprayBottle,
        Family::Shoe,
        Family::DeskLamp,
        Family::Duck,
    ];

    /// The name used in scene files, streams and tables.
    pub fn name(self) -> &'static str {
        match self {
            Family::Carton => "carton",
            Family::Can => "can",
            Family::Bottle => "bottle",
            Family::Mug => "mug",
            Family::Bowl => "bowl",
            Family::Book => "book",
            Family::ToyCar => "toy_car",
            Family::ToyHouse => "toy_house",
            Family::Figurine => "figurine",
            Family::Teapot => "teapot",
            Family::Crate => "crate",
            Family::Vase => "vase",
            Family::SprayBottle => "spray_bottle",
            Family::Shoe => "shoe",
            Family::DeskLamp => "desk_lamp",
            Family::Duck => "duck",
        }
    }

    /// Turns about z that leave every instance's look unchanged.
    pub fn symmetry(self) -> Symmetry {
        match self {
            Family::Crate => Symmetry::Cyclic { order: 4 },
            Family::Vase => Symmetry::Revolution,
            _ => Symmetry::None,
        }
    }

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
