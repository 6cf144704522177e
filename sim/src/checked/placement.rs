//! What stands in a room: within its walls, and not in one another; and whether the objects can find room on it.

use super::SceneSpec;
use super::path::{MANY, STRIDE};
use crate::object::{Fixture, LEAST_FOOTPRINT, MeshLibrary};
use crate::plan::block::Block;
use crate::plan::body::RADIUS as ROBOT_RADIUS;
use crate::plan::furnishing::blocks;
use crate::plan::stand::{Outline, Stand};
use crate::plan::track::Track;
use crate::scene::{PathSpec, RobotSpec, RoomSpec, SurfaceSpec, WorldSpec};
use nalgebra::Vector3;
use rapier3d::glamx::Pose3;
use rapier3d::parry::query::intersection_test;
use rapier3d::prelude::SharedShape;
use std::fmt;

/// What stands side by side may touch: by so much may parts reach into one another, or into a wall, metres.
pub const SLACK: f64 = 0.001;
/// What is lower than this, such as a carpet, may lie under furniture, metres.
const CARPET: f64 = 0.03;

/// A part of the world that stands where a scene file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The table, or the pedestals.
    Surface,
    /// A piece of furniture, by its index in the file.
    Piece(usize),
    /// Furniture from a file, by its index.
    Fixture(usize),
    /// The number of objects.
    Objects,
}

/// A part that cannot stand where it is put.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misplaced {
    /// The part.
    pub part: Part,
    /// Why, and what to change.
    pub reason: String,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Part::Surface => write!(f, "world.surface"),
            Part::Piece(index) => write!(f, "world.surface.furniture[{index}]"),
            Part::Fixture(index) => write!(f, "world.fixtures[{index}]"),
            Part::Objects => write!(f, "world.objects"),
        }
    }
}

impl fmt::Display for Misplaced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.part, self.reason)
    }
}

/// A part as it stands in the world.
struct Standing {
    part: Part,
    bounds: Block,
    shapes: Vec<(Pose3, SharedShape)>,
}

/// Every part that reaches beyond the room, into another part, or into a fixed path; and objects that are too many for any layout.
pub fn misplaced(spec: &SceneSpec, meshes: &MeshLibrary, fixtures: &[Fixture]) -> Vec<Misplaced> {
    let mut standing = on_surface(spec);
    standing.extend(fixtures.iter().enumerate().map(|(i, fixture)| Standing {
        part: Part::Fixture(i),
        bounds: fixture.bounds(),
        shapes: vec![fixture.shape(SLACK)],
    }));
    let mut found: Vec<Misplaced> = standing.iter().filter_map(|one| beyond(&spec.world.room, one)).collect();
    for (i, one) in standing.iter().enumerate() {
        if let Some(other) = standing[..i].iter().find(|other| overlap(other, one)) {
            let reason = format!("stands in {}; move one of them, or make it smaller", other.part);
            found.push(Misplaced { part: one.part, reason });
        }
    }
    found
        .extend(fixtures.iter().enumerate().filter_map(|(i, fixture)| blocked(&spec.robot.path, i, fixture)));
    found.extend(too_many(&spec.world, &spec.robot, meshes));
    found
}

/// More objects than would cover all stands if every one were the smallest there can be. Each pedestal has one.
fn too_many(world: &WorldSpec, robot: &RobotSpec, meshes: &MeshLibrary) -> Option<Misplaced> {
    if matches!(world.surface, SurfaceSpec::Pedestals { .. }) {
        return None;
    }
    let families = (!world.families.is_empty()).then_some(LEAST_FOOTPRINT);
    let smallest = meshes.iter().map(|mesh| mesh.footprint()).chain(families).reduce(f64::min)?;
    // Discs that reach half the spacing beyond the objects do not meet, nor leave their stand by more than that.
    let margin = world.spacing / 2.0;
    let disc = Outline::Disc { radius: smallest + margin }.area();
    let stands = world.surface.furnish(robot, 0).stands;
    let room: f64 = stands.iter().map(|stand| (stand.outline.grown(margin).area() / disc).floor()).sum();
    (f64::from(world.objects) > room).then(|| {
        let reason = format!(
            "{} objects do not fit on the {}, which would have no room for more than {room:.0} even of the smallest ones; use \
             fewer objects, a smaller world.spacing, or a larger surface",
            world.objects,
            world.surface.name()
        );
        Misplaced { part: Part::Objects, reason }
    })
}

fn on_surface(spec: &SceneSpec) -> Vec<Standing> {
    let surface = &spec.world.surface;
    if let SurfaceSpec::Furniture(pieces) = surface {
        let piece = |(i, piece)| {
            let blocks = blocks(piece);
            let bounds = blocks.iter().copied().reduce(Block::around)?;
            let shapes = blocks.iter().map(|block| block.shape(SLACK)).collect();
            Some(Standing { part: Part::Piece(i), bounds, shapes })
        };
        return pieces.iter().enumerate().filter_map(piece).collect();
    }
    let stands = surface.furnish(&spec.robot, spec.world.objects.min(MANY) as usize).stands;
    let standing = |stand: &Stand| {
        let [x, y] = stand.outline.half_extents();
        let half = Vector3::new(x, y, stand.height / 2.0);
        let center = stand.center.push(half.z);
        let bounds = Block { min: center - half, max: center + half };
        Standing { part: Part::Surface, bounds, shapes: vec![stand.shape()] }
    };
    stands.iter().map(standing).collect()
}

fn beyond(room: &RoomSpec, standing: &Standing) -> Option<Misplaced> {
    let half = Vector3::new(room.length / 2.0, room.width / 2.0, room.height);
    let reach = standing.bounds.max.sup(&-standing.bounds.min);
    (0..3).any(|axis| reach[axis] > half[axis] + SLACK).then(|| {
        let Block { min, max } = standing.bounds;
        let reason = format!(
            "from ({:.2}, {:.2}) to ({:.2}, {:.2}) and {:.2} m high, it reaches beyond world.room, {} x {} m and {} m \
             high; move it, or enlarge the room",
            min.x, min.y, max.x, max.y, max.z, room.length, room.width, room.height
        );
        Misplaced { part: standing.part, reason }
    })
}

/// Whether two parts meet. Pedestals, which are level, may.
fn overlap(a: &Standing, b: &Standing) -> bool {
    let apart = (0..3).any(|axis| {
        a.bounds.max[axis] < b.bounds.min[axis] + SLACK || b.bounds.max[axis] < a.bounds.min[axis] + SLACK
    });
    if apart || a.part == b.part || a.bounds.max.z.min(b.bounds.max.z) < CARPET {
        return false;
    }
    a.shapes.iter().any(|(at_a, a)| {
        b.shapes.iter().any(|(at_b, b)| {
            intersection_test(at_a, a.as_ref(), at_b, b.as_ref()).is_ok_and(|found| found.intersecting)
        })
    })
}

/// Furniture in a fixed path's way.
fn blocked(path: &PathSpec, index: usize, fixture: &Fixture) -> Option<Misplaced> {
    let track = Track::fixed(path)?;
    let middle = fixture.world_from_model.translation.vector.xy();
    let distances = track.samples(STRIDE).map(|waypoint| (waypoint.position - middle).norm());
    let (gap, needed) = (distances.fold(f64::INFINITY, f64::min), fixture.footprint() + ROBOT_RADIUS);
    (gap < needed).then(|| {
        let reason = format!(
            "the path passes at {gap:.2} m from its middle, expected at least {needed:.2} m; move it or the path"
        );
        Misplaced { part: Part::Fixture(index), reason }
    })
}
