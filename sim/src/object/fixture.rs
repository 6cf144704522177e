//! Meshes that stand where they are put: furniture.

use crate::mesh_file::find::{Source, find};
use crate::mesh_file::{self, MeshFault, MeshFileError, Units};
use crate::model::Model;
use crate::render::{NO_OBJECT, Placement};
use crate::world::convert::pose_to_physics;
use nalgebra::Vector3;
use rapier3d::prelude::{ColliderBuilder, SharedShape, Vector};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vantage_dataset::Pose;

/// A piece of furniture from a mesh file; its origin is the centre of its bounding box.
#[derive(Clone, Debug)]
pub struct Fixture {
    /// Its look.
    pub model: Arc<Model>,
    /// Half its extents along x, y, z, metres.
    pub half_extents: Vector3<f64>,
    /// BLAKE3 hash of the contents of all files that it was read from, hexadecimal.
    pub hash: String,
    /// A licence file that lies beside it.
    pub licence: Option<PathBuf>,
    shape: SharedShape,
}

impl Fixture {
    /// Reads a file, or a folder that holds one mesh.
    pub fn load(path: &Path, units: Units) -> Result<Self, MeshFileError> {
        let sources = find(path)?;
        let [source]: [Source; 1] = sources.try_into().map_err(|found: Vec<Source>| MeshFileError {
            path: path.to_owned(),
            fault: MeshFault::TooMany { what: "meshes", got: found.len(), limit: 1 },
        })?;
        let loaded = mesh_file::load(&source, units)?;
        let mesh = &loaded.model.mesh;
        let vertices = mesh.positions.iter().map(|&p| Vector::from(p)).collect();
        let shape = SharedShape::trimesh(vertices, mesh.triangles.clone())
            .map_err(|_| source.error(MeshFault::NoTriangle))?;
        Ok(Self {
            half_extents: mesh.half_extents(),
            hash: loaded.hash.to_hex().to_string(),
            licence: source.licence,
            shape,
            model: Arc::new(loaded.model),
        })
    }

    /// A fixed collider that is the surface itself, as seen from both sides.
    pub fn collider(&self, world_from_model: &Pose) -> ColliderBuilder {
        ColliderBuilder::new(self.shape.clone()).position(pose_to_physics(world_from_model))
    }

    /// What is drawn of it.
    pub fn placement(&self, world_from_model: &Pose) -> Placement {
        Placement { model: Arc::clone(&self.model), world_from_model: *world_from_model, id: NO_OBJECT }
    }
}
