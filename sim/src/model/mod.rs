//! What a renderer draws: a mesh with its texture.

mod hull;
mod simpler;

use crate::mesh::Mesh;
use crate::texture::Texture;
pub(crate) use hull::Hull;
use simpler::Simpler;
use std::sync::OnceLock;

/// Meshes of files have more triangles than this, and levels of detail save what they cost however seldom they are drawn.
const MANY_TRIANGLES: usize = 4000;

/// A textured mesh.
#[derive(Clone, Debug)]
pub struct Model {
    /// Geometry.
    pub mesh: Mesh,
    /// Albedo.
    pub texture: Texture,
    hull: Hull,
    /// Coarser from one to the next.
    simpler: OnceLock<Vec<Simpler>>,
}

impl Model {
    /// A mesh and the texture that its coordinates refer to.
    pub fn new(mesh: Mesh, texture: Texture) -> Self {
        Self { hull: Hull::around(&mesh.positions), mesh, texture, simpler: OnceLock::new() }
    }

    /// Makes levels of detail even of a small mesh: of use to a model that is drawn hundreds of times, before it is drawn first.
    pub fn simplify(&self) {
        self.simpler.get_or_init(|| simpler::all(&self.mesh));
    }

    /// The coarsest level of detail that deviates from the mesh by at most so many metres; 0 is the mesh itself.
    pub fn level(&self, deviation: f64) -> usize {
        self.simpler().iter().take_while(|simpler| simpler.deviation <= deviation).count()
    }

    /// The mesh of a level of detail, the coarsest if there are fewer.
    pub fn mesh_at(&self, level: usize) -> &Mesh {
        match self.simpler().get(..level.min(self.simpler().len())) {
            Some([.., simpler]) => &simpler.mesh,
            _ => &self.mesh,
        }
    }

    /// How many levels there are beside the mesh itself.
    pub fn simpler_levels(&self) -> usize {
        self.simpler().len()
    }

    pub(crate) fn hull(&self) -> &Hull {
        &self.hull
    }

    fn simpler(&self) -> &[Simpler] {
        self.simpler.get_or_init(|| {
            if self.mesh.triangles.len() < MANY_TRIANGLES { Vec::new() } else { simpler::all(&self.mesh) }
        })
    }
}

impl PartialEq for Model {
    /// Whether what was given is the same.
    fn eq(&self, other: &Self) -> bool {
        self.mesh == other.mesh && self.texture == other.texture
    }
}
