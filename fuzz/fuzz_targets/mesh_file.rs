//! A file read as the mesh of a scene.

use std::fs;
use vantage_sim::object::MeshLibrary;
use vantage_sim::scene::{MeshSpec, SymmetrySpec, UpAxis};

/// Reads `bytes` from a file of this name: a mesh or an error.
pub fn read(name: &str, bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join(name), bytes).expect("a file");
    let spec = MeshSpec {
        path: name.into(),
        metres_per_unit: 1.0,
        up: UpAxis::Y,
        category: None,
        symmetry: SymmetrySpec::None,
        split: None,
    };
    let _ = MeshLibrary::load(&[spec], folder.path(), None, &mut |_| ());
}
