//! The scene of the renderers' benchmark: a table set with objects of every family, or with others.

use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;
use vantage_dataset::{Camera, Pose, Seed, Split};
use vantage_sim::mesh::Mesh;
use vantage_sim::model::Model;
use vantage_sim::object::Object;
use vantage_sim::render::{Frame, Light, NO_OBJECT, Placement, RenderScene, Shot, TileShot};
use vantage_sim::scene::Family;
use vantage_sim::texture::{TEXTURE_SIDE, Texture};

const COLUMNS: usize = 6;
const ROWS: usize = 5;
/// Between neighbours, metres.
const SPACING: f64 = 0.26;
/// Cells along each side of the table's top.
const CELLS: u32 = 8;
/// An object with fewer pixels in a frame has no tile.
const LEAST_PIXELS: usize = 50;
/// Side of a window over that of the box around what is visible.
const MARGIN: f64 = 1.25;

/// A part of a shot, around one object.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Index of the shot.
    pub shot: usize,
    /// Centre, pixels of the shot.
    pub center: [f64; 2],
    /// Side, pixels of the shot.
    pub side: f64,
    /// The object.
    pub target: u32,
}

const SEED: Seed = Seed(7);

/// The table set with objects of every family.
pub fn scene() -> RenderScene {
    set_with(|i| {
        let family = Family::ALL[i % Family::ALL.len()];
        Object::generate(family, Split::Train, SEED, (i / Family::ALL.len()) as u64)
    })
}

/// The table set with other objects, one for each place; their ids are counted from 1.
pub fn set_with(object: impl Fn(usize) -> Object) -> RenderScene {
    let table = Placement { model: table(), world_from_model: Pose::identity(), id: NO_OBJECT };
    let standing = (0..COLUMNS * ROWS).map(|i| {
        let mut stream = SEED.stream("benchmark/layout", i as u64);
        let object = object(i);
        // As a world does.
        object.model.simplify();
        let mut place = |index: usize, count: usize| {
            SPACING * ((index as f64 - (count - 1) as f64 / 2.0) + stream.uniform(-0.1, 0.1))
        };
        // 7 is prime to 30: neighbours are of different families.
        let cell = 7 * i % (COLUMNS * ROWS);
        let [x, y] = [place(cell % COLUMNS, COLUMNS), place(cell / COLUMNS, ROWS)];
        Placement {
            model: Arc::clone(&object.model),
            world_from_model: Pose::new(
                Vector3::new(x, y, object.half_extents.z),
                Vector3::z() * stream.uniform(0.0, TAU),
            ),
            id: i as u32 + 1,
        }
    });
    RenderScene {
        placements: std::iter::once(table).chain(standing).collect(),
        light: Light { direction: Vector3::new(0.36, -0.48, 0.8), ambient: [0.4; 3], diffuse: [0.6; 3] },
        background: [90, 120, 160],
    }
}

/// Shots from around the table.
pub fn shots(count: usize) -> Vec<Shot> {
    (0..count)
        .map(|i| {
            let (sin, cos) = libm::sincos(TAU * i as f64 / count as f64);
            let height = 0.5 + 0.1 * (i % 3) as f64;
            let eye = Point3::new(1.35 * cos, 1.2 * sin, height);
            let target = Point3::new(0.55 * cos + 0.15 * sin, 0.45 * sin - 0.15 * cos, 0.0);
            Shot {
                camera: Camera::with_horizontal_fov(320, 240, 0.6),
                world_from_camera: Pose::face_towards(&eye, &target, &-Vector3::z()),
            }
        })
        .collect()
}

/// Windows around the objects that a frame of a shot shows.
pub fn windows(shot: usize, frame: &Frame) -> Vec<Window> {
    let width = frame.width as usize;
    let window = |target: u32| {
        let seen: Vec<_> = (0..frame.ids.len())
            .filter(|&i| frame.ids[i] == target)
            .map(|i| [i % width, i / width])
            .collect();
        (seen.len() >= LEAST_PIXELS).then(|| {
            let range = |axis: usize| {
                let low = seen.iter().map(|pixel| pixel[axis]).min().unwrap_or(0);
                let high = seen.iter().map(|pixel| pixel[axis] + 1).max().unwrap_or(0);
                (low as f64, high as f64)
            };
            let [x, y] = [range(0), range(1)];
            let side = MARGIN * (x.1 - x.0).max(y.1 - y.0);
            Window { shot, center: [(x.0 + x.1) / 2.0, (y.0 + y.1) / 2.0], side, target }
        })
    };
    (1..=(COLUMNS * ROWS) as u32).filter_map(window).collect()
}

impl Window {
    /// What a renderer is asked for.
    pub fn tile<'a>(&self, scene: &'a RenderScene, shots: &[Shot]) -> TileShot<'a> {
        TileShot { scene, shot: shots[self.shot], center: self.center, side: self.side, target: self.target }
    }
}

/// A checkered top of `CELLS * CELLS` quads.
fn table() -> Arc<Model> {
    let half = [1.0, 0.85];
    let mut mesh = Mesh::default();
    let corners = CELLS + 1;
    for i in 0..corners * corners {
        let [u, v] = [i % corners, i / corners].map(|step| step as f32 / CELLS as f32);
        mesh.positions.push([half[0] * (2.0 * u - 1.0), half[1] * (1.0 - 2.0 * v), 0.0]);
        mesh.normals.push([0.0, 0.0, 1.0]);
        mesh.uvs.push([u, v]);
    }
    for cell in 0..CELLS * CELLS {
        let first = cell / CELLS * corners + cell % CELLS;
        let [right, below] = [first + 1, first + corners];
        mesh.triangles.push([first, below, below + 1]);
        mesh.triangles.push([first, below + 1, right]);
    }
    let texel = |i: usize| {
        let check = (i / TEXTURE_SIDE / 8 + i % TEXTURE_SIDE / 8).is_multiple_of(2);
        if check { [110, 96, 80, 255] } else { [190, 178, 160, 255] }
    };
    let texture = Texture::new((0..TEXTURE_SIDE * TEXTURE_SIDE).map(texel).collect());
    Arc::new(Model::new(mesh, texture))
}
