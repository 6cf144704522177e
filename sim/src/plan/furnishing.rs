//! What stands in the room: stands for objects, and pieces of furniture.

use super::block::Block;
use super::stand::{Outline, Stand};
use super::track::Track;
use crate::scene::{PathSpec, PieceSpec, RobotSpec, Side, SurfaceSpec};
use nalgebra::{Vector2, Vector3};

/// Thickness of boards, sides and tops, metres.
const BOARD: f64 = 0.03;
/// Side of a table's legs, metres.
const LEG: f64 = 0.06;

/// The surface of a scene: what objects stand on, and what stands beside it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Furnishing {
    /// What objects are put on. Tables and pedestals are solid; the others are the upper sides of blocks.
    pub stands: Vec<Stand>,
    /// Pieces of furniture, each a set of blocks.
    pub pieces: Vec<Vec<Block>>,
}

impl Furnishing {
    /// The outlines that a robot has to keep away from, with their centres.
    pub fn obstacles(&self) -> Vec<(Vector2<f64>, Outline)> {
        let solid = self.stands.iter().filter(|stand| stand.solid).map(|stand| (stand.center, stand.outline));
        let pieces = self.pieces.iter().map(|blocks| {
            let min = blocks.iter().fold(Vector2::repeat(f64::INFINITY), |m, b| m.inf(&b.min.xy()));
            let max = blocks.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |m, b| m.sup(&b.max.xy()));
            let half = (max - min) / 2.0;
            (min + half, Outline::Rectangle { half_extents: half.into() })
        });
        solid.chain(pieces).collect()
    }
}

impl SurfaceSpec {
    /// What a world has for this many objects; a table is one stand, pedestals are one an object.
    pub fn furnish(&self, robot: &RobotSpec, objects: usize) -> Furnishing {
        let center = Vector2::zeros();
        let one = |height, outline| Furnishing {
            stands: vec![Stand::solid(center, height, outline)],
            ..Furnishing::default()
        };
        match self {
            Self::RoundTable { radius, height } => one(*height, Outline::Disc { radius: *radius }),
            Self::RectangularTable { length, width, height } => {
                one(*height, Outline::Rectangle { half_extents: [length / 2.0, width / 2.0] })
            }
            Self::Pedestals { radius, height, offset } => {
                let beside_fixed = || Some((Track::fixed(&robot.path)?, robot.camera.yaw_deg >= 0.0));
                let beside_which = match &robot.path {
                    // Between the laps: on the left of the one outside.
                    PathSpec::InsideAndOutside(spec) => Some((Track::circle(spec.outer_radius), true)),
                    _ => beside_fixed(),
                };
                let Some((track, left)) = beside_which else { return Furnishing::default() };
                let stands = (0..objects)
                    .map(|i| {
                        let share = (i as f64 + 0.5) / objects as f64;
                        let center = beside(&track, share, left, *offset);
                        Stand::solid(center, *height, Outline::Disc { radius: *radius })
                    })
                    .collect();
                Furnishing { stands, ..Furnishing::default() }
            }
            Self::Furniture(pieces) => {
                let mut furnishing = Furnishing::default();
                for piece in pieces {
                    furnishing.pieces.push(blocks(piece));
                    furnishing.stands.extend(stands(piece));
                }
                furnishing
            }
        }
    }

    /// What it is called in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::RoundTable { .. } => "round table",
            Self::RectangularTable { .. } => "rectangular table",
            Self::Pedestals { .. } => "pedestals",
            Self::Furniture(_) => "furniture",
        }
    }
}

fn beside(track: &Track, share: f64, left: bool, offset: f64) -> Vector2<f64> {
    let waypoint = track.waypoint(share * track.length());
    let to_the_left = Vector2::new(-waypoint.tangent.y, waypoint.tangent.x);
    waypoint.position + to_the_left * if left { offset } else { -offset }
}

/// A box from extents relative to the piece's middle on the floor.
fn block(at: [f64; 2], x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Block {
    Block {
        min: Vector3::new(at[0] + x[0], at[1] + y[0], z[0]),
        max: Vector3::new(at[0] + x[1], at[1] + y[1], z[1]),
    }
}

/// The solid parts of a piece.
pub fn blocks(piece: &PieceSpec) -> Vec<Block> {
    let (at, [length, width, height]) = piece.extent();
    let (x, y) = (length / 2.0, width / 2.0);
    match piece {
        PieceSpec::Cabinet { .. } | PieceSpec::Block { .. } => {
            vec![block(at, [-x, x], [-y, y], [0.0, height])]
        }
        PieceSpec::Table { .. } => {
            let ends = |half: f64| [[-half, LEG - half], [half - LEG, half]];
            let legs = ends(x).into_iter().flat_map(|along_x| {
                ends(y).map(|along_y| block(at, along_x, along_y, [0.0, height - BOARD]))
            });
            let top = block(at, [-x, x], [-y, y], [height - BOARD, height]);
            legs.chain([top]).collect()
        }
        PieceSpec::Shelves { boards, open_to, .. } => {
            let inside = |side: Side, edge: f64| if side == *open_to { edge } else { edge - BOARD };
            let along_x = [-inside(Side::West, x), inside(Side::East, x)];
            let along_y = [-inside(Side::South, y), inside(Side::North, y)];
            let walls = [
                (Side::East, block(at, [x - BOARD, x], [-y, y], [0.0, height])),
                (Side::North, block(at, along_x, [y - BOARD, y], [0.0, height])),
                (Side::West, block(at, [-x, BOARD - x], [-y, y], [0.0, height])),
                (Side::South, block(at, along_x, [-y, BOARD - y], [0.0, height])),
            ];
            let closed = walls.into_iter().filter(|(side, _)| side != open_to).map(|(_, wall)| wall);
            let boards = boards.iter().map(|top| block(at, along_x, along_y, [top - BOARD, *top]));
            closed.chain(boards).collect()
        }
    }
}

fn stands(piece: &PieceSpec) -> Vec<Stand> {
    let (at, [length, width, height]) = piece.extent();
    let top = |height: f64, headroom: f64, inset: f64| Stand {
        center: at.into(),
        height,
        outline: Outline::Rectangle { half_extents: [length / 2.0 - inset, width / 2.0 - inset] },
        headroom,
        solid: false,
    };
    match piece {
        PieceSpec::Block { .. } => Vec::new(),
        PieceSpec::Table { .. } | PieceSpec::Cabinet { .. } => vec![top(height, f64::INFINITY, 0.0)],
        PieceSpec::Shelves { boards, .. } => boards
            .iter()
            .enumerate()
            .map(|(i, board)| {
                let above = boards.get(i + 1).map_or(f64::INFINITY, |next| next - BOARD);
                top(*board, above - board, BOARD)
            })
            .collect(),
    }
}
