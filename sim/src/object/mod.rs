//! Procedural objects: what the world is furnished with.
//!
//! An [`Object`] is drawn from its [`Family`], split, seed and index alone, so that a training set of thousands needs
//! no files. Frames: z up, front = +x, left = +y, origin at the centre of the bounding box; metres and kilograms.

mod catalog;
mod family;
mod hull;
mod paint;
mod solid;

pub use catalog::Catalog;
pub use family::Family;

use crate::mesh::Mesh;
use crate::model::Model;
use crate::texture::Texture;
use family::Draft;
use nalgebra::Vector3;
use std::sync::Arc;
use vantage_dataset::{InstanceId, Seed, Split, Symmetry};

/// An object instance.
#[derive(Clone, Debug)]
pub struct Object {
    /// Hash of family, mesh and texture.
    pub id: InstanceId,
    /// Its family.
    pub family: Family,
    /// Its look.
    pub model: Arc<Model>,
    /// Turns about z that leave its look unchanged.
    pub symmetry: Symmetry,
    /// Diameter of the sphere about the origin that holds it, metres.
    pub size: f64,
    /// Half its extents along x, y, z, metres.
    pub half_extents: Vector3<f64>,
    /// Vertices of (nearly) its convex hull, at most 64.
    pub hull: Vec<[f32; 3]>,
    /// Mass, kilograms.
    pub mass: f64,
}

impl Object {
    /// Draws instance `index` of a family; different splits draw from different streams.
    pub fn generate(family: Family, split: Split, seed: Seed, index: u64) -> Self {
        let stream =
            |part: &str| seed.stream(&format!("object/{}/{}/{part}", split.name(), family.name()), index);
        let Draft { solid, canvas, density } = family.draft(&mut stream("shape"), &mut stream("look"));
        let (low, high) = solid.bounds();
        let center = 0.5 * (low + high);
        let mass = density * solid.volume();
        let mesh = solid.moved(-center.x, -center.y, -center.z).to_mesh();
        let texture = canvas.to_texture();
        let radius_squared = mesh.positions.iter().map(|p| {
            let p = p.map(f64::from);
            p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
        });
        Self {
            id: identity(family, &mesh, &texture),
            family,
            symmetry: family.symmetry(),
            size: 2.0 * radius_squared.fold(0.0, f64::max).sqrt(),
            half_extents: 0.5 * (high - low),
            hull: hull::hull(&mesh.positions),
            mass,
            model: Arc::new(Model::new(mesh, texture)),
        }
    }
}

/// The first 8 bytes of the hash over family, mesh and the finest texture level, all bits.
fn identity(family: Family, mesh: &Mesh, texture: &Texture) -> InstanceId {
    let mut hasher = blake3::Hasher::new();
    hasher.update(family.name().as_bytes());
    hasher.update(bytemuck::cast_slice(&mesh.positions));
    hasher.update(bytemuck::cast_slice(&mesh.normals));
    hasher.update(bytemuck::cast_slice(&mesh.uvs));
    hasher.update(bytemuck::cast_slice(&mesh.triangles));
    hasher.update(bytemuck::cast_slice(&texture.levels[0]));
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&hasher.finalize().as_bytes()[..8]);
    InstanceId(u64::from_le_bytes(bytes))
}
