//! Meshes from files: OBJ with MTL, glTF and GLB become [`Model`]s.
//!
//! A file is untrusted: sizes are checked before memory is taken, nothing outside the mesh's folder is read, and
//! every fault is a [`MeshFileError`] that names file and cause. Its unit and its upward axis are stated by the one who
//! names the file, never guessed.
//!
//! One texture holds all materials of a mesh: each gets a part of it, into which the range of the image that its
//! triangles show is resampled, repetitions included. Transparency is not drawn; colours at vertices are refused.

mod atlas;
mod bake;
mod color;
mod error;
pub(crate) mod files;
pub(crate) mod find;
mod gltf;
mod image;
mod obj;
mod soup;
mod surface;
mod turn;

pub use error::{MeshFault, MeshFileError};

use crate::mesh::Mesh;
use crate::model::Model;
use crate::scene::UpAxis;
use files::Files;
use find::Source;
use nalgebra::Vector3;
use std::collections::HashMap;
use surface::Facet;

/// Most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 500_000;
/// Most vertices of a mesh; in an OBJ file, positions, texture coordinates and normals together.
pub const MAX_VERTICES: usize = 2_000_000;

impl UpAxis {
    /// A vector in the file's axes, along this project's.
    fn to_z_up(self, [x, y, z]: [f32; 3]) -> Vector3<f64> {
        match self {
            UpAxis::Z => Vector3::new(x, y, z),
            UpAxis::Y => Vector3::new(z, x, y),
        }
        .map(f64::from)
    }
}

/// How the numbers of a file are meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Length of the file's unit, metres.
    pub metres_per_unit: f64,
    /// The axis that points up.
    pub up: UpAxis,
}

/// A mesh from a file.
pub(crate) struct Loaded {
    pub model: Model,
    /// Hash of the contents of all files that it was read from.
    pub hash: blake3::Hash,
    /// The files that the mesh file names, in the order in which they were read.
    pub names: Vec<String>,
}

/// Reads a mesh with all it names.
pub(crate) fn load(source: &Source, units: Units) -> Result<Loaded, MeshFileError> {
    let mut files = Files::new(source)?;
    let is_obj = source.file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj"));
    let read = if is_obj { obj::read } else { gltf::read };
    let soup = read(&mut files, &source.file)?;
    let refused = |fault| files.error(fault);
    let mut facets = surface::surface(&soup, units).map_err(refused)?;
    let texture = bake::bake(&mut facets, &soup.materials, &soup.images).map_err(refused)?;
    let model = Model::new(indexed(&facets), texture);
    Ok(Loaded { model, hash: files.hash(), names: files.names() })
}

/// The mesh whose vertices are the corners that differ.
fn indexed(facets: &[Facet]) -> Mesh {
    let single = |v: &Vector3<f64>| -> [f32; 3] { v.map(|x| x as f32).into() };
    let mut mesh = Mesh::default();
    let mut known: HashMap<[u32; 8], u32> = HashMap::new();
    for facet in facets {
        let corner = |i: usize| {
            let (position, normal) = (single(&facet.points[i]), single(&facet.normals[i]));
            let uv = facet.uvs[i].map(|t| t as f32);
            let [x, y, z] = position;
            let [l, m, n] = normal;
            *known.entry([x, y, z, l, m, n, uv[0], uv[1]].map(f32::to_bits)).or_insert_with(|| {
                mesh.positions.push(position);
                mesh.normals.push(normal);
                mesh.uvs.push(uv);
                mesh.positions.len() as u32 - 1
            })
        };
        let corners = [0, 1, 2].map(corner);
        mesh.triangles.push(corners);
    }
    mesh
}
