//! Colour of each pixel: trilinear albedo times light.

use super::super::{Light, NO_OBJECT, RenderScene};
use super::canvas::{Canvas, NO_FACET};
use super::raster::{Facet, PlaneRow};
use super::tables::{LEVEL_STEPS, TABLES, Tables, round_small};
use crate::texture::Texture;

/// Steps of a texel, and of a mip level.
const STEPS: i32 = 256;

/// Low bytes of four 16-bit lanes.
const LANES: u64 = 0x00ff_00ff_00ff_00ff;

/// One half of the lanes' steps.
const HALVES: u64 = 0x0080_0080_0080_0080;

/// Shades what a canvas holds of a scene.
pub(super) struct Shader<'a> {
    scene: &'a RenderScene,
    tables: &'static Tables,
}

impl<'a> Shader<'a> {
    pub fn new(scene: &'a RenderScene) -> Self {
        Self { scene, tables: &TABLES }
    }

    /// sRGB bytes and ids, row-major.
    pub fn shade(&self, canvas: &Canvas) -> (Vec<u8>, Vec<u32>) {
        let mut rgb = Vec::with_capacity(3 * canvas.nearest.len());
        let mut ids = Vec::with_capacity(canvas.nearest.len());
        let width = canvas.width as usize;
        let rows = canvas.nearest.chunks_exact(width).zip(canvas.inverse_depth.chunks_exact(width));
        for (row, (facets, inverse_depths)) in (0..).zip(rows) {
            let mut column = 0;
            for run in facets.chunk_by(PartialEq::eq) {
                let columns = column..column + run.len();
                column = columns.end;
                if run[0] == NO_FACET {
                    rgb.extend(std::iter::repeat_n(self.scene.background, run.len()).flatten());
                    ids.extend(std::iter::repeat_n(NO_OBJECT, run.len()));
                } else {
                    let facet = &canvas.facets[run[0] as usize];
                    let placement = &self.scene.placements[facet.placement as usize];
                    let first = columns.start as i32 - facet.left;
                    let band = Band::new(facet, &placement.model.texture, row - facet.top);
                    for (column, inverse_depth) in (first..).zip(&inverse_depths[columns]) {
                        rgb.extend(self.pixel(&band, column, 1.0 / inverse_depth));
                    }
                    ids.extend(std::iter::repeat_n(placement.id, run.len()));
                }
            }
        }
        (rgb, ids)
    }

    fn pixel(&self, band: &Band<'_>, column: i32, depth: f32) -> [u8; 3] {
        let [u, v, incidence] = band.varyings.map(|varying| varying.at(column) * depth);
        let [over_u, over_v, nearness] = band.slopes;
        let along = |axis: usize| {
            let [u, v] = [over_u[axis] - u * nearness[axis], over_v[axis] - v * nearness[axis]];
            u * u + v * v
        };
        let texels = depth * band.texture.side() as f32;
        let footprint = along(0).max(along(1)) * (texels * texels);
        let albedo = sample(band.texture, u, v, self.tables.half_log2(footprint));
        let Light { ambient, diffuse, .. } = &self.scene.light;
        let incidence = incidence.max(0.0);
        std::array::from_fn(|channel| {
            let linear = self.tables.linear(albedo[channel]);
            self.tables.encode(linear * (ambient[channel] + diffuse[channel] * incidence))
        })
    }
}

/// What is the same along a row of a facet.
#[derive(Debug)]
struct Band<'a> {
    texture: &'a Texture,
    /// u, v and `n . l`, each over depth.
    varyings: [PlaneRow; 3],
    /// Changes of u over depth, of v over depth, and of 1 over depth: a column on, and a row on.
    slopes: [[f32; 2]; 3],
}

impl<'a> Band<'a> {
    fn new(facet: &Facet, texture: &'a Texture, row: i32) -> Self {
        let [u, v, _] = &facet.varyings;
        Self {
            texture,
            varyings: facet.varyings.map(|varying| varying.row(row)),
            slopes: [u, v, &facet.inverse_depth].map(|plane| [plane.per_column, plane.per_row]),
        }
    }
}

/// Trilinear filtering with repeating coordinates at a level of detail in [`STEPS`]; RGB in [`LEVEL_STEPS`] of a level.
fn sample(texture: &Texture, u: f32, v: f32, detail: i32) -> [usize; 3] {
    let coarsest = texture.levels.len() as i32 - 1;
    let detail = detail.clamp(0, coarsest * STEPS);
    let (level, fraction) = ((detail / STEPS) as usize, (detail % STEPS) as u64);
    let [x, y] = [u, v].map(|along| round_small(along * (texture.side() as i32 * STEPS) as f32));
    let bilinear =
        |level: usize| bilinear(&texture.levels[level], texture.side() >> level, x >> level, y >> level);
    let fine = bilinear(level);
    let mixed = if fraction == 0 {
        fine
    } else {
        let coarse = bilinear(level + 1);
        let rounded = |lanes: u64| ((lanes + HALVES) >> 8) & LANES;
        rounded(fine) * (STEPS as u64 - fraction) + rounded(coarse) * fraction
    };
    let channel = |shift: u32| {
        let steps = (mixed >> shift) as usize & 0xffff;
        (steps + STEPS as usize / LEVEL_STEPS / 2) / (STEPS as usize / LEVEL_STEPS)
    };
    [channel(0), channel(32), channel(16)]
}

/// The four texels around a point given in [`STEPS`] of a texel; 16-bit lanes R, B, G, A in [`STEPS`].
fn bilinear(texels: &[[u8; 4]], side: usize, x: i32, y: i32) -> u64 {
    let (x, y) = (x.wrapping_sub(STEPS / 2), y.wrapping_sub(STEPS / 2));
    let wrap = |texel: i32| texel as usize & (side - 1);
    let (left, right) = (wrap(x >> 8), wrap((x >> 8) + 1));
    let (top, bottom) = (wrap(y >> 8) * side, wrap((y >> 8) + 1) * side);
    let (fx, fy) = ((x & 255) as u64, (y & 255) as u64);
    let both = (fx * fy) >> 8;
    let lanes = |index: usize| {
        let texel = u64::from(u32::from_le_bytes(texels[index]));
        (texel | texel << 24) & LANES
    };
    lanes(top + left) * (STEPS as u64 - fx - fy + both)
        + lanes(top + right) * (fx - both)
        + lanes(bottom + left) * (fy - both)
        + lanes(bottom + right) * both
}
