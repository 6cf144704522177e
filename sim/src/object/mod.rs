//! Objects: what the world is furnished with.
//!
//! A procedural [`Object`] is drawn from its [`Family`], split, seed and index alone, so that a training set of
//! thousands needs no files; others are read from mesh files into a [`MeshLibrary`]. Frames: z up, front = +x,
//! left = +y, origin at the centre of the bounding box; metres and kilograms.

mod catalog;
mod extents;
mod family;
mod fixture;
mod hull;
mod library;
mod paint;
mod prepared;
mod self_similarity;
mod shape;
mod shelf;
mod solid;
mod tint;

pub use catalog::{Catalog, Draw};
pub use fixture::Fixture;
pub use library::{MeshEntry, MeshLibrary};
pub use self_similarity::self_similarity;

use crate::mesh::Mesh;
use crate::model::Model;
use crate::scene::Family;
use crate::texture::Texture;
use family::Draft;
use nalgebra::Vector3;
use shape::Shape;
use std::sync::Arc;
use vantage_dataset::{InstanceId, Seed, Split, Symmetry};

/// No instance of a family has a circle about its footprint of a smaller radius, metres: the narrowest vase has one of 0.024.
pub const LEAST_FOOTPRINT: f64 = 0.02;

/// An object instance.
#[derive(Clone, Debug)]
pub struct Object {
    /// Hash of family, mesh and texture, or of the contents of the mesh's files.
    pub id: InstanceId,
    /// What it is a tinted copy of; itself where it is none.
    pub original: InstanceId,
    /// Name of its family, or of the category of a mesh.
    pub family: String,
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
        let id = identity(family.name(), &mesh, &texture);
        Self {
            id,
            original: id,
            family: family.name().to_owned(),
            symmetry: family.symmetry(),
            size: mesh.diameter(),
            half_extents: 0.5 * (high - low),
            hull: hull::hull(&mesh.positions),
            mass,
            model: Arc::new(Model::new(mesh, texture)),
        }
    }

    /// Radius of the circle around its footprint where it stands upright, metres.
    pub fn footprint(&self) -> f64 {
        libm::hypot(self.half_extents[0], self.half_extents[1])
    }

    /// The object that a mesh is.
    fn from_mesh(id: InstanceId, category: String, symmetry: Symmetry, shape: Shape, model: Model) -> Self {
        let Shape { size, half_extents, hull, mass } = shape;
        let model = Arc::new(model);
        Self { id, original: id, family: category, model, symmetry, size, half_extents, hull, mass }
    }
}

/// The first 8 bytes of the hash over family, mesh and the finest texture level, all bits.
fn identity(family: &str, mesh: &Mesh, texture: &Texture) -> InstanceId {
    let mut hasher = blake3::Hasher::new();
    hasher.update(family.as_bytes());
    hasher.update(bytemuck::cast_slice(&mesh.positions));
    hasher.update(bytemuck::cast_slice(&mesh.normals));
    hasher.update(bytemuck::cast_slice(&mesh.uvs));
    hasher.update(bytemuck::cast_slice(&mesh.triangles));
    hasher.update(bytemuck::cast_slice(texture.level(0)));
    first_bytes(&hasher.finalize())
}

/// The first 8 bytes of a hash.
fn first_bytes(hash: &blake3::Hash) -> InstanceId {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&hash.as_bytes()[..8]);
    InstanceId(u64::from_le_bytes(bytes))
}
