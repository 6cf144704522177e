//! What a renderer draws: a mesh with its texture.

mod simpler;

use crate::mesh::Mesh;
use crate::texture::Texture;
use simpler::Simpler;
use std::sync::OnceLock;

/// A textured mesh.
#[derive(Clone, Debug)]
pub struct Model {
    /// Geometry.
    pub mesh: Mesh,
    /// Albedo.
    pub texture: Texture,
    /// Made of the mesh when first asked for; coarser from one to the next.
    simpler: OnceLock<Vec<Simpler>>,
}

impl Model {
    /// A mesh and the texture that its coordinates refer to.
    pub fn new(mesh: Mesh, texture: Texture) -> Self {
        Self { mesh, texture, simpler: OnceLock::new() }
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

    fn simpler(&self) -> &[Simpler] {
        self.simpler.get_or_init(|| simpler::all(&self.mesh))
    }
}

impl PartialEq for Model {
    /// Whether what was given is the same.
    fn eq(&self, other: &Self) -> bool {
        self.mesh == other.mesh && self.texture == other.texture
    }
}
