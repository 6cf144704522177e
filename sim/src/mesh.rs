//! Triangle meshes in an object's own frame.

/// A UV-mapped triangle mesh, metres, z up, counter-clockwise seen from outside.
///
/// Vertices are per corner where normals or texture coordinates break.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one a vertex.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates in `[0, 1]`, v down, one a vertex.
    pub uvs: Vec<[f32; 2]>,
    /// Corners of each triangle, indices into the vertices.
    pub triangles: Vec<[u32; 3]>,
}
