//! What a renderer draws: a mesh with its texture.

mod hull;
mod simpler;

use crate::mesh::Mesh;
use crate::texture::Texture;
pub(crate) use hull::Hull;
pub(crate) use simpler::Simpler;
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

    /// A model with the levels of detail that [`Model::own_levels`] told.
    pub(crate) fn with_levels(mesh: Mesh, texture: Texture, levels: Vec<Simpler>) -> Self {
        let model = Self::new(mesh, texture);
        // Of a small mesh none were made, which does not mean that there are none.
        if model.is_fine() { Self { simpler: levels.into(), ..model } } else { model }
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

    /// The levels of detail that it has without [`Model::simplify`], coarser from one to the next.
    pub(crate) fn own_levels(&self) -> &[Simpler] {
        if self.is_fine() { self.simpler() } else { &[] }
    }

    fn simpler(&self) -> &[Simpler] {
        self.simpler.get_or_init(|| if self.is_fine() { simpler::all(&self.mesh) } else { Vec::new() })
    }

    fn is_fine(&self) -> bool {
        self.mesh.triangles.len() >= MANY_TRIANGLES
    }
}

impl PartialEq for Model {
    /// Whether what was given is the same.
    fn eq(&self, other: &Self) -> bool {
        self.mesh == other.mesh && self.texture == other.texture
    }
}
