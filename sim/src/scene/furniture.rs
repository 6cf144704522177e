//! `world.surface.furniture`: pieces along the world's axes.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// A piece of furniture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PieceSpec {
    /// A top on four legs; objects stand on it.
    Table {
        /// Its middle `[x, y]`, metres.
        #[garde(custom(in_reach))]
        at: [f64; 2],
        /// Extents along x, y and z, metres.
        #[garde(custom(piece_sized))]
        size: [f64; 3],
    },
    /// A block; objects stand on it.
    Cabinet {
        /// Its middle `[x, y]`, metres.
        #[garde(custom(in_reach))]
        at: [f64; 2],
        /// Extents along x, y and z, metres.
        #[garde(custom(piece_sized))]
        size: [f64; 3],
    },
    /// Boards between two sides with a back; objects stand on the boards.
    Shelves {
        /// Its middle `[x, y]`, metres.
        #[garde(custom(in_reach))]
        at: [f64; 2],
        /// Extents along x, y and z, metres.
        #[garde(custom(piece_sized))]
        size: [f64; 3],
        /// Heights of the boards' tops, metres, from below.
        #[garde(length(min = 1, max = 10), custom(rising_below(size[2])))]
        boards: Vec<f64>,
        /// The open side.
        #[garde(skip)]
        open_to: Side,
    },
    /// Sofas, partitions and the like: a block that nothing stands on.
    Block {
        /// Its middle `[x, y]`, metres.
        #[garde(custom(in_reach))]
        at: [f64; 2],
        /// Extents along x, y and z, metres.
        #[garde(custom(piece_sized))]
        size: [f64; 3],
    },
}

/// A side of a piece, by the world's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Positive x.
    East,
    /// Positive y.
    North,
    /// Negative x.
    West,
    /// Negative y.
    South,
}

impl PieceSpec {
    /// Its middle and its extents, metres.
    pub fn extent(&self) -> ([f64; 2], [f64; 3]) {
        match *self {
            Self::Table { at, size }
            | Self::Cabinet { at, size }
            | Self::Shelves { at, size, .. }
            | Self::Block { at, size } => (at, size),
        }
    }
}

fn in_reach(at: &[f64; 2], _: &()) -> garde::Result {
    at.iter().try_for_each(|x| not_nan(x, &()))?;
    if at.iter().all(|x| x.abs() <= 250.0) {
        return Ok(());
    }
    Err(garde::Error::new(format!("got {at:?}, expected coordinates within 250 m of the origin")))
}

fn piece_sized(size: &[f64; 3], _: &()) -> garde::Result {
    size.iter().try_for_each(|x| not_nan(x, &()))?;
    if size.iter().all(|x| (0.1..=50.0).contains(x)) && size[2] <= 3.0 {
        return Ok(());
    }
    Err(garde::Error::new(format!("got {size:?}, expected 0.1 to 50 m along x and y and 0.1 to 3 m along z")))
}

/// Room that a board needs above it, metres.
const HEADROOM: f64 = 0.1;

fn rising_below(top: f64) -> impl Fn(&Vec<f64>, &()) -> garde::Result {
    move |boards, ()| {
        let in_order = boards.windows(2).all(|pair| pair[1] >= pair[0] + HEADROOM);
        let inside = boards.iter().all(|height| (0.05..=top).contains(height));
        if in_order && inside {
            return Ok(());
        }
        Err(garde::Error::new(format!(
            "got {boards:?}, expected heights from 0.05 to {top} m, each at least {HEADROOM} m above the one before"
        )))
    }
}
