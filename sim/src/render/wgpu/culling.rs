//! Leaving out triangles that cover no pixel's centre.
//!
//! They are most of an object in a small tile, and where the device is a CPU, as much work as the others.

use super::super::candidates::Candidates;
use super::super::view::{SUBPIXELS, Vertex, View};
use super::super::{Light, Placement, Shot};
use std::ops::Range;
use vantage_dataset::widest::widest;

/// By how much the device may see a corner elsewhere, subpixels: Vulkan asks for no finer grid than 1/16 pixel, half of which a corner
/// moves, and single precision adds less than the other half, but for corners next to the near plane.
const SLACK: i32 = SUBPIXELS / 16;

/// The triangles that are left of meshes.
#[derive(Debug, Default)]
pub(super) struct Culling {
    /// Corners, indices into the vertices of each triangle's mesh.
    pub triangles: Vec<[u32; 3]>,
    vertices: Vec<Vertex>,
    candidates: Candidates,
}

impl Culling {
    /// Adds those of a placement's level of detail, in their order, and returns their range among the corners of all.
    pub fn add(&mut self, shot: &Shot, light: &Light, (placement, level): (&Placement, usize)) -> Range<u32> {
        let mesh = placement.model.mesh_at(level);
        let view = View::new(shot, placement, light);
        let size = [shot.camera.width as i32, shot.camera.height as i32];
        let first = 3 * self.triangles.len() as u32;
        widest(
            #[inline(always)]
            || {
                view.project(&mesh.positions, &mut self.vertices);
                let numbers = self.candidates.find(&mesh.triangles, &self.vertices, size, SLACK);
                self.triangles.extend(numbers.iter().map(|&number| mesh.triangles[number as usize]));
            },
        );
        first..3 * self.triangles.len() as u32
    }
}
