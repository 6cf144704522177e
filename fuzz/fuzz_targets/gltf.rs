//! glTF and GLB files: a mesh or an error, whatever the bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::fs;
use vantage_sim::object::MeshLibrary;
use vantage_sim::scene::{MeshSpec, SymmetrySpec, UpAxis};

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("mesh.gltf"), bytes).expect("a file");
    let spec = MeshSpec {
        path: "mesh.gltf".into(),
        metres_per_unit: 1.0,
        up: UpAxis::Y,
        category: None,
        symmetry: SymmetrySpec::None,
        split: None,
    };
    let _ = MeshLibrary::load(&[spec], folder.path(), &mut |_| ());
});
