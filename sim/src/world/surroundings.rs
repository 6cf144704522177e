//! The room and the stands, as they are drawn.

use crate::mesh::Mesh;
use crate::model::Model;
use crate::object::Fixture;
use crate::plan::block::Block;
use crate::plan::furnishing::Furnishing;
use crate::plan::stand::{Outline, Stand};
use crate::render::{NO_OBJECT, Placement};
use crate::scene::RoomSpec;
use crate::world::wallpaper;
use nalgebra::{Translation3, Vector2, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use vantage_dataset::{Pose, Seed};

/// Side of the panels that floors and walls are made of, metres, before they are fitted to the room.
const PANEL: f64 = 1.5;
/// Corners of a round stand's outline.
const CORNERS: usize = 40;

/// Floor, walls, stands and furniture, each with a texture of its own drawn from the seed; all stands share one.
pub fn placements(
    room: &RoomSpec,
    furnishing: &Furnishing,
    fixtures: &[Fixture],
    seed: Seed,
) -> Vec<Placement> {
    let texture = |index: u64| wallpaper::draw(&mut seed.stream("wallpaper", index));
    let placed = |mesh: Mesh, texture: u64, world_from_model: Pose| Placement {
        model: Arc::new(Model::new(mesh, wallpaper::draw(&mut seed.stream("wallpaper", texture)))),
        world_from_model,
        id: NO_OBJECT,
    };
    let mut drawn = vec![
        placed(floor(room), 0, Pose::identity()),
        placed(walls(room, [0, 2]), 1, Pose::identity()),
        placed(walls(room, [1, 3]), 2, Pose::identity()),
    ];
    drawn.extend(furnishing.pieces.iter().zip(4..).map(|(blocks, texture)| {
        let mut mesh = Mesh::default();
        blocks.iter().for_each(|block| add_block(&mut mesh, block));
        placed(mesh, texture, Pose::identity())
    }));
    drawn.extend(fixtures.iter().map(Fixture::placement));
    let solid = || furnishing.stands.iter().filter(|stand| stand.solid);
    let Some(first) = solid().next() else { return drawn };
    let model = Arc::new(Model::new(stand_mesh(first), texture(3)));
    drawn.extend(solid().map(|stand| Placement {
        model: Arc::clone(&model),
        world_from_model: Translation3::new(stand.center.x, stand.center.y, 0.0).into(),
        id: NO_OBJECT,
    }));
    drawn
}

fn floor(room: &RoomSpec) -> Mesh {
    let mut mesh = Mesh::default();
    let corner = Vector3::new(-room.length / 2.0, -room.width / 2.0, 0.0);
    add_panels(&mut mesh, corner, Vector3::x() * room.length, Vector3::y() * room.width);
    mesh
}

/// Two of the four walls, counted counter-clockwise from the one at negative y; they face inward.
fn walls(room: &RoomSpec, which: [usize; 2]) -> Mesh {
    let (x, y) = (room.length / 2.0, room.width / 2.0);
    let corners = [Vector2::new(-x, -y), Vector2::new(x, -y), Vector2::new(x, y), Vector2::new(-x, y)];
    let mut mesh = Mesh::default();
    for wall in which {
        let (from, to) = (corners[(wall + 1) % 4], corners[wall]);
        let along = to - from;
        add_panels(
            &mut mesh,
            Vector3::new(from.x, from.y, 0.0),
            Vector3::new(along.x, along.y, 0.0),
            Vector3::z() * room.height,
        );
    }
    mesh
}

fn stand_mesh(stand: &Stand) -> Mesh {
    let outline: Vec<Vector2<f64>> = match stand.outline {
        Outline::Disc { radius } => (0..CORNERS)
            .map(|i| {
                let angle = 2.0 * PI * i as f64 / CORNERS as f64;
                Vector2::new(libm::cos(angle), libm::sin(angle)) * radius
            })
            .collect(),
        Outline::Rectangle { half_extents: [x, y] } => {
            vec![Vector2::new(x, y), Vector2::new(-x, y), Vector2::new(-x, -y), Vector2::new(x, -y)]
        }
    };
    let mut mesh = Mesh::default();
    add_top(&mut mesh, &outline, stand.height);
    for (i, from) in outline.iter().enumerate() {
        let to = outline[(i + 1) % outline.len()];
        let along = to - from;
        add_quad(
            &mut mesh,
            Vector3::new(from.x, from.y, 0.0),
            Vector3::new(along.x, along.y, 0.0),
            Vector3::z() * stand.height,
            [i as f64 / outline.len() as f64, (i + 1) as f64 / outline.len() as f64],
        );
    }
    mesh
}

/// A convex polygon, counter-clockwise about the origin, facing up.
fn add_top(mesh: &mut Mesh, outline: &[Vector2<f64>], height: f64) {
    let first = mesh.positions.len() as u32;
    let reach = outline.iter().map(|p| p.amax()).fold(0.0, f64::max);
    for corner in outline {
        let uv = corner / (2.0 * reach);
        push(mesh, &Vector3::new(corner.x, corner.y, height), &Vector3::z(), [0.5 + uv.x, 0.5 - uv.y]);
    }
    for i in 1..outline.len() as u32 - 1 {
        mesh.triangles.push([first, first + i, first + i + 1]);
    }
}

/// A parallelogram of panels that each show the whole texture; it faces `along x up`.
fn add_panels(mesh: &mut Mesh, corner: Vector3<f64>, along: Vector3<f64>, up: Vector3<f64>) {
    let count = |edge: &Vector3<f64>| (edge.norm() / PANEL).round().max(1.0);
    let (columns, rows) = (count(&along), count(&up));
    let (step, rise) = (along / columns, up / rows);
    for row in 0..rows as u32 {
        for column in 0..columns as u32 {
            let at = corner + step * f64::from(column) + rise * f64::from(row);
            add_quad(mesh, at, step, rise, [0.0, 1.0]);
        }
    }
}

/// A box, all sides facing outward but the one that lies on the floor, which is left out.
fn add_block(mesh: &mut Mesh, block: &Block) {
    let size = block.max - block.min;
    let [x, y, z] = [Vector3::x() * size.x, Vector3::y() * size.y, Vector3::z() * size.z];
    add_quad(mesh, block.min, x, z, [0.0, 1.0]);
    add_quad(mesh, block.min + x, y, z, [0.0, 1.0]);
    add_quad(mesh, block.min + x + y, -x, z, [0.0, 1.0]);
    add_quad(mesh, block.min + y, -y, z, [0.0, 1.0]);
    add_quad(mesh, block.min + z, x, y, [0.0, 1.0]);
    if block.min.z > 0.0 {
        add_quad(mesh, block.min, y, x, [0.0, 1.0]);
    }
}

fn add_quad(mesh: &mut Mesh, corner: Vector3<f64>, along: Vector3<f64>, up: Vector3<f64>, u: [f64; 2]) {
    let first = mesh.positions.len() as u32;
    let normal = along.cross(&up).normalize();
    push(mesh, &corner, &normal, [u[0], 1.0]);
    push(mesh, &(corner + along), &normal, [u[1], 1.0]);
    push(mesh, &(corner + along + up), &normal, [u[1], 0.0]);
    push(mesh, &(corner + up), &normal, [u[0], 0.0]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

fn push(mesh: &mut Mesh, position: &Vector3<f64>, normal: &Vector3<f64>, uv: [f64; 2]) {
    mesh.positions.push(position.map(|x| x as f32).into());
    mesh.normals.push(normal.map(|x| x as f32).into());
    mesh.uvs.push(uv.map(|t| t as f32));
}
