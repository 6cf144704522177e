//! glTF and GLB files: a mesh or an error, whatever the bytes.

#![no_main]

mod mesh_file;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| mesh_file::read("mesh.gltf", bytes));
