//! Meshes from files: how they look, what is refused, and how scenes use them.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod files;
mod folders;
mod hostile;
mod hostile_gltf;
mod look;
#[cfg(unix)]
mod prepared;
mod real;
mod scene;
