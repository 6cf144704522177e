//! Why a mesh file is refused.

use std::path::PathBuf;
use vantage_dataset::store::StoreError;

/// A mesh file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the mesh {}: {fault}", path.display())]
pub struct MeshFileError {
    /// The file or folder.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: MeshFault,
}

/// What is wrong with a mesh file.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MeshFault {
    /// The system does not give it.
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// Not a kind of file that is read.
    #[error("is no file that ends in .obj, .gltf or .glb, and no folder")]
    UnknownFormat,
    /// A folder without meshes.
    #[error(
        "the folder holds no mesh; expected a .obj, .gltf or .glb file, `textured.obj` (YCB; also in `google_16k` or \
         `tsdf`), `meshes/model.obj` (Google Scanned Objects), or folders that hold one of these"
    )]
    NoMeshInFolder,
    /// Larger than any sensible mesh.
    #[error("`{name}` has {bytes} bytes; at most {limit} of a mesh and all it names are read: simplify it")]
    FileTooLarge { name: String, bytes: u64, limit: u64 },
    /// More than a renderer can take.
    #[error("got {got} {what}, at most {limit} are read; simplify the mesh")]
    TooMany { what: &'static str, got: usize, limit: usize },
    /// It names a file that is not there.
    #[error("names the file `{name}`, which cannot be read: {source}; put it beside the mesh")]
    MissingFile {
        /// As it was named.
        name: String,
        source: std::io::Error,
    },
    /// It names a file somewhere else.
    #[error(
        "names the file `{name}`, which is not in the mesh's folder; copy it there and name it without a path"
    )]
    OutsideFolder {
        /// As it was named.
        name: String,
    },
    /// The text or its structure is broken.
    #[error("`{name}` is not valid: {reason}")]
    Syntax { name: String, reason: String },
    /// Geometry or a look that only an extension could read.
    #[error("uses the glTF extension {0}, which is not read; export the mesh without it")]
    Extension(String),
    /// A feature that would change how the mesh looks.
    #[error("has {0}, which is not read; {1}")]
    Unsupported(&'static str, &'static str),
    /// A reference to something that is not there.
    #[error("an index of {what} is out of range: got {got}, expected less than {len}")]
    Index { what: &'static str, got: u64, len: usize },
    /// NaN, infinite or absurdly large.
    #[error("a {0} is not finite or absurdly large")]
    NotFinite(&'static str),
    /// There is nothing to see.
    #[error("has no triangle")]
    NoTriangle,
    /// There are only points and lines to see.
    #[error("none of its {0} triangles has an area")]
    NoArea(usize),
    /// The convex hull is degenerate.
    #[error("its convex hull has no volume: nothing could collide with it")]
    NoVolume,
    /// Too small or too large.
    #[error(
        "its largest extent is {extent:.6} m with `metres_per_unit: {metres_per_unit}`, expected from {} to {} m; is \
         `metres_per_unit` right?",
        range[0], range[1]
    )]
    Size {
        extent: f64,
        /// As the scene states it.
        metres_per_unit: f64,
        /// Smallest and largest, metres.
        range: [f64; 2],
    },
    /// An image that cannot be decoded.
    #[error("the image `{name}` is not valid: {reason}")]
    Image { name: String, reason: String },
    /// A texture that nothing maps to the surface.
    #[error("the material `{0}` has a texture, but its surface has no texture coordinates")]
    NoTextureCoordinates(String),
    /// A surface without a look.
    #[error("some faces use a material that is not in its MTL file, which has {0}")]
    UnknownMaterial(String),
    /// The same contents twice: it would belong to two splits.
    #[error("is the same mesh as {}; list it once", .0.display())]
    Twice(PathBuf),
    /// It is no longer what the scene was checked with.
    #[error("has changed since the scene was read; start again")]
    Changed,
    /// Its prepared form has no place.
    #[error("what was prepared of it cannot be kept: {0}")]
    NotKept(Box<StoreError>),
}
