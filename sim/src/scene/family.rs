//! The families of procedural objects, by name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Symmetry;

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
    /// One to six parts of any shape, anyhow joined: an instance tells nothing of another's front.
    Composite,
}

impl Family {
    /// All families.
    pub const ALL: [Family; 17] = [
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
        Family::Composite,
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
            Family::Composite => "composite",
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
}
