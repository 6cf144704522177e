//! What a renderer draws: a mesh with its texture.

use crate::mesh::Mesh;
use crate::texture::Texture;

/// A textured mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Geometry.
    pub mesh: Mesh,
    /// Albedo.
    pub texture: Texture,
}
