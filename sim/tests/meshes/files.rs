//! Small mesh files.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::{Rgb, RgbImage};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use vantage_sim::mesh_file::MeshFileError;
use vantage_sim::object::{MeshEntry, MeshLibrary, Object};
use vantage_sim::scene::UpAxis;
use vantage_sim::scene::{MeshSpec, SymmetrySpec};

/// Corners of a unit cube, z up.
pub const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
/// Its faces, counter-clockwise from outside, the lower edge first.
pub const FACES: [[usize; 4]; 6] =
    [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7], [3, 2, 1, 0]];

/// The vertices and texture corners of a unit cube as an OBJ file has them.
pub fn obj_vertices() -> String {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    vertices + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
}

/// Faces of it, each of which shows the whole image upright.
pub fn obj_faces(faces: &[[usize; 4]]) -> String {
    faces.iter().map(|[a, b, c, d]| format!("f {}/1 {}/2 {}/3 {}/4\n", a + 1, b + 1, c + 1, d + 1)).collect()
}

/// A cube with one material, `skin`, of `cube.mtl`.
pub fn obj_cube() -> String {
    format!("mtllib cube.mtl\n{}usemtl skin\n{}", obj_vertices(), obj_faces(&FACES))
}

/// Red above blue.
pub fn flag(side: u32) -> RgbImage {
    RgbImage::from_fn(side, side, |_, y| if y < side / 2 { Rgb([200, 0, 0]) } else { Rgb([0, 0, 200]) })
}

/// A folder with a cube that shows the flag on each side.
pub fn cube_folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "cube.obj", &obj_cube());
    write(folder.path(), "cube.mtl", "newmtl skin\nmap_Kd flag.png\n");
    flag(64).save(folder.path().join("flag.png")).unwrap();
    folder
}

pub fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, text).unwrap();
    path
}

/// A tenth of a metre to the unit.
pub fn spec(path: impl Into<PathBuf>) -> MeshSpec {
    MeshSpec {
        path: path.into(),
        metres_per_unit: 0.1,
        up: UpAxis::Z,
        category: None,
        symmetry: SymmetrySpec::None,
        split: None,
    }
}

pub fn load_all(path: impl Into<PathBuf>) -> Result<MeshLibrary, MeshFileError> {
    MeshLibrary::load(&[spec(path)], Path::new(""), None, &mut |_| ())
}

/// The only mesh.
pub fn load(path: impl Into<PathBuf>) -> MeshEntry {
    load_all(path).unwrap().iter().next().unwrap().clone()
}

/// Asserts that two objects are equal to the bit, levels of detail included.
pub fn assert_same(a: &Object, b: &Object) {
    let bits = |object: &Object| {
        let model = &object.model;
        let meshes = (0..=model.simpler_levels()).map(|level| model.mesh_at(level));
        let numbers = meshes.flat_map(|mesh| {
            let floats =
                [mesh.positions.as_flattened(), mesh.normals.as_flattened(), mesh.uvs.as_flattened()];
            let floats = floats.into_iter().flatten().map(|x| x.to_bits());
            floats.chain(mesh.triangles.as_flattened().iter().copied()).collect::<Vec<u32>>()
        });
        let [x, y, z] = object.half_extents.into();
        let shape = [object.size, object.mass, x, y, z].map(f64::to_bits);
        (
            numbers.collect::<Vec<u32>>(),
            shape,
            object.hull.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<u32>>(),
        )
    };
    assert_eq!(a.id, b.id);
    assert!(bits(a) == bits(b), "{} has changed", a.family);
    assert_eq!(a.model.texture, b.model.texture);
    let levels = |object: &Object| [1e-4, 1e-3, 1e-2].map(|deviation| object.model.level(deviation));
    assert_eq!(levels(a), levels(b));
    assert_eq!((&a.family, a.original, a.symmetry), (&b.family, b.original, b.symmetry));
}

/// A buffer as a data URI.
pub fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(bytes))
}

/// The unit cube as glTF (z up, which the scene has to say), its indices first in the buffer, then its positions.
pub fn gltf_cube() -> Value {
    let indices: Vec<u16> =
        FACES.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d].map(|i| i as u16)).collect();
    let bytes: Vec<u8> = indices
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .chain(CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()))
        .collect();
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5123, "count": 36, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 72 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 96 },
        ],
        "buffers": [{ "byteLength": 168, "uri": data_uri(&bytes) }],
    })
}

/// The binary form of a glTF file whose one buffer is a data URI.
pub fn glb(mut gltf: Value) -> Vec<u8> {
    let uri = gltf["buffers"][0].as_object_mut().unwrap().remove("uri").unwrap();
    let (_, text) = uri.as_str().unwrap().split_once(',').unwrap();
    let mut binary = BASE64_STANDARD.decode(text).unwrap();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut text = gltf.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let mut file = b"glTF".to_vec();
    file.extend([2, length as u32].map(u32::to_le_bytes).concat());
    file.extend((text.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(text);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}
