//! Meshes that stand where they are put: furniture from files.

use crate::convert::{pose_to_physics, vector_to_physics};
use crate::mesh_file::find::{Source, find};
use crate::mesh_file::{self, MeshFault, MeshFileError, Units};
use crate::model::Model;
use crate::plan::block::Block;
use crate::plan::stand::Outline;
use crate::render::{NO_OBJECT, Placement};
use crate::scene::FixtureSpec;
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use rapier3d::glamx::Pose3;
use rapier3d::prelude::{ColliderBuilder, SharedShape, Vector};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use vantage_dataset::Pose;

/// A piece of furniture from a mesh file, which stands on the floor.
///
/// It is serialized as what decides how it looks and where it stands, but for the scene's own words: as part of a key.
#[derive(Clone, Debug, Serialize)]
pub struct Fixture {
    /// BLAKE3 hash of the contents of all files that it was read from, hexadecimal.
    pub hash: String,
    /// Where it stands; its origin is the centre of its bounding box.
    #[serde(skip)]
    pub world_from_model: Pose,
    /// Half its extents along x, y, z, metres.
    #[serde(skip)]
    pub half_extents: Vector3<f64>,
    #[serde(skip)]
    model: Arc<Model>,
    #[serde(skip)]
    shape: SharedShape,
}

impl PartialEq for Fixture {
    fn eq(&self, other: &Self) -> bool {
        (&self.hash, &self.world_from_model) == (&other.hash, &other.world_from_model)
    }
}

impl Fixture {
    /// Reads a file, or a folder that holds one mesh; its path is relative to the folder `base`.
    pub fn load(spec: &FixtureSpec, base: &Path) -> Result<Self, MeshFileError> {
        let path = base.join(&spec.path);
        let [source]: [Source; 1] = find(&path)?.try_into().map_err(|found: Vec<Source>| MeshFileError {
            path,
            fault: MeshFault::TooMany { what: "meshes", got: found.len(), limit: 1 },
        })?;
        let units = Units { metres_per_unit: spec.metres_per_unit, up: spec.up };
        let loaded = mesh_file::load(&source, units)?;
        let mesh = &loaded.model.mesh;
        let vertices = mesh.positions.iter().map(|&p| Vector::from(p)).collect();
        let shape = SharedShape::trimesh(vertices, mesh.triangles.clone())
            .map_err(|_| source.error(MeshFault::NoTriangle))?;
        let half_extents = loaded.model.hull().half_extents;
        let world_from_model = Pose::from_parts(
            Translation3::new(spec.at[0], spec.at[1], half_extents.z),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), spec.yaw_deg.to_radians()),
        );
        Ok(Self {
            hash: loaded.hash.to_hex().to_string(),
            world_from_model,
            half_extents,
            shape,
            model: Arc::new(loaded.model),
        })
    }

    /// A fixed collider that is the surface itself, as seen from both sides.
    pub fn collider(&self) -> ColliderBuilder {
        ColliderBuilder::new(self.shape.clone()).position(pose_to_physics(&self.world_from_model))
    }

    /// Its surface for the physics engine, less `slack` metres on all sides.
    pub fn shape(&self, slack: f64) -> (Pose3, SharedShape) {
        let scale = self.half_extents.map(|half| (1.0 - slack / half).max(0.0));
        let shape = match self.shape.as_trimesh() {
            Some(mesh) => SharedShape::new(mesh.clone().scaled(vector_to_physics(&scale))),
            None => self.shape.clone(),
        };
        (pose_to_physics(&self.world_from_model), shape)
    }

    /// The box around it along the world's axes.
    pub fn bounds(&self) -> Block {
        let points = self
            .model
            .mesh
            .positions
            .iter()
            .map(|&point| self.world_from_model * Point3::from(point.map(f64::from)));
        let corner = |point: Point3<f64>| Block { min: point.coords, max: point.coords };
        let at = self.world_from_model.translation.vector;
        points.map(corner).reduce(Block::around).unwrap_or(Block { min: at, max: at })
    }

    /// What is drawn of it.
    pub fn placement(&self) -> Placement {
        Placement { model: Arc::clone(&self.model), world_from_model: self.world_from_model, id: NO_OBJECT }
    }

    /// The outline that a robot has to keep away from, with its centre.
    pub fn obstacle(&self) -> (Vector2<f64>, Outline) {
        (self.world_from_model.translation.vector.xy(), Outline::Disc { radius: self.footprint() })
    }

    /// Radius of the circle around its footprint, metres.
    pub fn footprint(&self) -> f64 {
        libm::hypot(self.half_extents.x, self.half_extents.y)
    }
}
