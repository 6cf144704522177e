//! How one placement is seen: from the model's frame to pixels and light.

use super::projection::{light_in_model, pixels_from_model};
use super::{Light, NEAR, Placement, Shot};
use nalgebra::Matrix3x4;

/// Subpixels of a pixel, as on GPUs.
pub(super) const SUBPIXELS: i32 = 256;

/// Farthest pixel coordinate that the rasterizer's integers carry; what lies beyond is clipped.
pub(super) const GUARD: f64 = 8192.0;

/// Sides of the window on which a vertex lies outside; unknown before the near plane and outside the guard band.
pub(super) mod outside {
    pub const LEFT: u32 = 1;
    pub const RIGHT: u32 = 2;
    pub const TOP: u32 = 4;
    pub const BOTTOM: u32 = 8;
    pub const NEAR: u32 = 16;
    /// Of the guard band, not of the window.
    pub const GUARD: u32 = 32;
    /// The vertex has no position.
    pub const UNPROJECTED: u32 = NEAR | GUARD;
}

/// A projected vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Position in subpixels; 0 where clipping is needed.
    pub x: i32,
    /// Likewise.
    pub y: i32,
    /// 1 / depth, 1/m; unset where clipping is needed.
    pub inverse_depth: f32,
    /// Bits of [`outside`].
    pub outside: u32,
}

/// Vertices that are projected together.
const BATCH: usize = 8;

/// A placement before a camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pixels_from_model: Matrix3x4<f64>,
    light_in_model: [f32; 3],
    /// Subpixels.
    width: i32,
    /// Subpixels.
    height: i32,
}

impl View {
    pub fn new(shot: &Shot, placement: &Placement, light: &Light) -> Self {
        Self {
            pixels_from_model: pixels_from_model(shot, placement),
            light_in_model: light_in_model(light, placement),
            width: shot.camera.width as i32 * SUBPIXELS,
            height: shot.camera.height as i32 * SUBPIXELS,
        }
    }

    /// `[column * depth, row * depth, depth]`.
    #[inline(always)]
    pub fn homogeneous(&self, position: [f32; 3]) -> [f64; 3] {
        let [x, y, z] = position.map(f64::from);
        let m = &self.pixels_from_model;
        std::array::from_fn(|row| m[(row, 0)] * x + m[(row, 1)] * y + (m[(row, 2)] * z + m[(row, 3)]))
    }

    /// Replaces `vertices` by the positions projected.
    #[inline(always)]
    pub fn project(&self, positions: &[[f32; 3]], vertices: &mut Vec<Vertex>) {
        vertices.clear();
        let (batches, rest) = positions.as_chunks::<BATCH>();
        for batch in batches {
            let mut projected = [Vertex { x: 0, y: 0, inverse_depth: 0.0, outside: 0 }; BATCH];
            for (vertex, &position) in projected.iter_mut().zip(batch) {
                *vertex = self.vertex(position);
            }
            vertices.extend_from_slice(&projected);
        }
        vertices.extend(rest.iter().map(
            #[inline(always)]
            |&position| self.vertex(position),
        ));
    }

    /// Without branches, so that the compiler can do several at once.
    #[inline(always)]
    fn vertex(&self, position: [f32; 3]) -> Vertex {
        let [x, y, z] = self.homogeneous(position);
        let inverse = 1.0 / z;
        let (column, row) = (x * inverse, y * inverse);
        let (x, y) = (snap(column), snap(row));
        let bit = |condition: bool, bit: u32| if condition { bit } else { 0 };
        let far = bit(z < NEAR, outside::NEAR) | bit(column.abs().max(row.abs()) > GUARD, outside::GUARD);
        let beyond = |distance: i32, bit: u32| (distance >> 31) as u32 & bit;
        let sides = beyond(x, outside::LEFT)
            | beyond(self.width.wrapping_sub(x), outside::RIGHT)
            | beyond(y, outside::TOP)
            | beyond(self.height.wrapping_sub(y), outside::BOTTOM);
        let projected = |subpixels: i32| if far == 0 { subpixels } else { 0 };
        Vertex {
            x: projected(x),
            y: projected(y),
            inverse_depth: inverse as f32,
            outside: if far == 0 { sides } else { far },
        }
    }

    /// `n . l`.
    #[inline(always)]
    pub fn incidence(&self, normal: [f32; 3]) -> f32 {
        let l = self.light_in_model;
        normal[0] * l[0] + normal[1] * l[1] + normal[2] * l[2]
    }
}

/// The pixels, up to a limit, whose centres are at most `slack` beyond the least and the greatest of a triangle's coordinates: the
/// first, and the first beyond.
#[inline(always)]
pub(super) fn pixels([a, b, c]: [i32; 3], limit: i32, slack: i32) -> (i32, i32) {
    const HALF: i32 = SUBPIXELS / 2;
    let (low, high) = (a.min(b).min(c) - slack, a.max(b).max(c) + slack);
    (((low + HALF - 1) >> 8).max(0), ((high + HALF) >> 8).min(limit))
}

/// The nearest subpixel of a coordinate within [`GUARD`], and any for others: faster than a cast, which saturates.
#[inline(always)]
pub(super) fn snap(pixels: f64) -> i32 {
    // A sum of this size keeps no fraction: its low bits are the integer.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    (pixels * f64::from(SUBPIXELS) + SHIFT).to_bits() as i32
}
