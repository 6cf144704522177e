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

impl Mesh {
    /// Diameter of the sphere about the origin that holds all vertices.
    pub(crate) fn diameter(&self) -> f64 {
        let radius_squared = self.positions.iter().map(|p| {
            let p = p.map(f64::from);
            p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
        });
        2.0 * radius_squared.fold(0.0, f64::max).sqrt()
    }
}
