//! Colour of each pixel: trilinear albedo times light.

use super::super::{Light, NO_OBJECT, RenderScene};
use super::canvas::{Canvas, NO_FACET};
use super::raster::Facet;
use super::tables::{LEVEL_STEPS, TABLES, Tables};
use crate::texture::{TEXTURE_SIDE, Texture};

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
        let mut rgb = vec![0; 3 * canvas.nearest.len()];
        let mut ids = vec![NO_OBJECT; canvas.nearest.len()];
        let width = canvas.width as usize;
        let rows = canvas.nearest.chunks_exact(width).zip(canvas.inverse_depth.chunks_exact(width));
        let outputs = rgb.chunks_exact_mut(3 * width).zip(ids.chunks_exact_mut(width));
        for (row, ((numbers, depths), (rgb, ids))) in rows.zip(outputs).enumerate() {
            let pixels = rgb.as_chunks_mut::<3>().0.iter_mut().zip(ids);
            for (column, ((pixel, id), (&number, &inverse_depth))) in
                pixels.zip(numbers.iter().zip(depths)).enumerate()
            {
                if number == NO_FACET {
                    *pixel = self.scene.background;
                    continue;
                }
                let facet = &canvas.facets[number as usize];
                let placement = &self.scene.placements[facet.placement as usize];
                let texture = &placement.model.texture;
                *pixel = self.pixel(facet, texture, column as i32, row as i32, 1.0 / inverse_depth);
                *id = placement.id;
            }
        }
        (rgb, ids)
    }

    fn pixel(&self, facet: &Facet, texture: &Texture, column: i32, row: i32, depth: f32) -> [u8; 3] {
        let (column, row) = (column - facet.left, row - facet.top);
        let [u, v, incidence] = facet.varyings.map(|varying| varying.row(row).at(column) * depth);
        let texels = depth * TEXTURE_SIDE as f32;
        let [over_u, over_v, _] = &facet.varyings;
        let nearness = &facet.inverse_depth;
        let along_row =
            [over_u.per_column - u * nearness.per_column, over_v.per_column - v * nearness.per_column];
        let along_column = [over_u.per_row - u * nearness.per_row, over_v.per_row - v * nearness.per_row];
        let squared = |change: [f32; 2]| change[0] * change[0] + change[1] * change[1];
        let footprint = squared(along_row).max(squared(along_column)) * (texels * texels);
        let albedo = sample(texture, u, v, self.tables.half_log2(footprint));
        let Light { ambient, diffuse, .. } = &self.scene.light;
        let incidence = incidence.max(0.0);
        std::array::from_fn(|channel| {
            let linear = self.tables.linear[albedo[channel]];
            self.tables.encode(linear * (ambient[channel] + diffuse[channel] * incidence))
        })
    }
}

/// Trilinear filtering with repeating coordinates at a level of detail in [`STEPS`]; RGB in [`LEVEL_STEPS`] of a level.
fn sample(texture: &Texture, u: f32, v: f32, detail: i32) -> [usize; 3] {
    let coarsest = texture.levels.len() as i32 - 1;
    let detail = detail.clamp(0, coarsest * STEPS);
    let (level, fraction) = ((detail / STEPS) as usize, (detail % STEPS) as u64);
    let x = (u * (TEXTURE_SIDE as i32 * STEPS) as f32) as i32;
    let y = (v * (TEXTURE_SIDE as i32 * STEPS) as f32) as i32;
    let fine = bilinear(&texture.levels[level], level, x, y);
    let mixed = if fraction == 0 {
        fine
    } else {
        let coarse = bilinear(&texture.levels[level + 1], level + 1, x, y);
        let rounded = |lanes: u64| ((lanes + HALVES) >> 8) & LANES;
        rounded(fine) * (STEPS as u64 - fraction) + rounded(coarse) * fraction
    };
    let channel = |shift: u32| {
        let steps = (mixed >> shift) as usize & 0xffff;
        (steps + STEPS as usize / LEVEL_STEPS / 2) * LEVEL_STEPS / STEPS as usize
    };
    [channel(0), channel(32), channel(16)]
}

/// The four texels around a point given in [`STEPS`] of the finest level's texels; 16-bit lanes R, B, G, A in [`STEPS`].
fn bilinear(texels: &[[u8; 4]], level: usize, x: i32, y: i32) -> u64 {
    let side = TEXTURE_SIDE >> level;
    let (x, y) = ((x >> level).wrapping_sub(STEPS / 2), (y >> level).wrapping_sub(STEPS / 2));
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
