//! Colour of each pixel: trilinear albedo times light.
//!
//! Pixels are shaded in batches, step by step, so that the compiler can do several at once.

use super::super::{Light, NO_OBJECT, RenderScene};
use super::canvas::NO_FACET;
use super::raster::Facet;
use super::tables::{LEVEL_STEPS, TABLES, Tables, round_small};
use std::ops::Range;

/// Steps of a texel, and of a mip level.
const STEPS: i32 = 256;

/// Pixels of a row that are shaded together.
const BATCH: usize = 32;

/// Pixels that a run's constants are stored for at once.
const STRIDE: usize = 8;

/// A number for each pixel of a batch, with room for the last stride.
type Lanes<T> = [T; BATCH + STRIDE];

/// Shades facets of a scene.
#[derive(Clone, Copy)]
pub(super) struct Shader<'a> {
    scene: &'a RenderScene,
    tables: &'static Tables,
}

/// Where a facet's pixels begin, and what changes over them.
#[derive(Debug)]
struct Planes {
    /// Column, counted from the facet's first.
    column: Lanes<i32>,
    /// u, v and `n . l`, each over depth, at the facet's first column.
    varyings: [Lanes<f32>; 3],
    /// Their changes along the row.
    per_column: [Lanes<f32>; 3],
    /// Changes of u and v over depth along a column.
    per_row: [Lanes<f32>; 2],
    /// Changes of 1 over depth along the row and a column.
    nearness: [Lanes<f32>; 2],
    /// Of the texture, and its coarsest level.
    side: Lanes<i32>,
    coarsest: Lanes<i32>,
}

/// Where a texture is sampled.
#[derive(Debug)]
struct Place {
    /// In [`STEPS`] of the finest level's texels.
    x: [i32; BATCH],
    /// Likewise.
    y: [i32; BATCH],
    /// Square of the pixel's extent, texels of the finest level.
    footprint: [f32; BATCH],
    /// Level in [`STEPS`], not clamped.
    detail: [i32; BATCH],
}

/// What is sampled.
#[derive(Debug)]
struct Taps {
    level: [i32; BATCH],
    /// Of the coarser level, in [`STEPS`].
    fraction: [u32; BATCH],
    /// Of the finer level and the coarser one: indices of the top left, top right, bottom left and bottom right texel.
    indices: [[[u32; BATCH]; 4]; 2],
    /// Likewise, in [`STEPS`].
    weights: [[[u32; BATCH]; 4]; 2],
    texels: [[[u32; BATCH]; 4]; 2],
    incidence: [f32; BATCH],
}

/// Consecutive pixels of a batch on one facet.
struct Run {
    columns: Range<usize>,
    facet: u32,
}

impl<'a> Shader<'a> {
    pub fn new(scene: &'a RenderScene) -> Self {
        Self { scene, tables: &TABLES }
    }

    /// Shades pixels of a row from the first column on: sRGB bytes and ids.
    #[inline(always)]
    pub fn shade_row(
        &self,
        batch: &mut Batch,
        facets: &[Facet],
        row: i32,
        (nearest, inverse_depth): (&[u32], &[f32]),
        (rgb, ids): (&mut [[u8; 3]], &mut [u32]),
    ) {
        let inputs = nearest.chunks(BATCH).zip(inverse_depth.chunks(BATCH));
        let outputs = rgb.chunks_mut(BATCH).zip(ids.chunks_mut(BATCH));
        for ((first, (nearest, inverse_depth)), (rgb, ids)) in (0..).step_by(BATCH).zip(inputs).zip(outputs) {
            batch.inverse_depth[..nearest.len()].copy_from_slice(inverse_depth);
            let drawn = self.planes(&mut batch.planes, facets, [first, row], nearest, ids);
            if drawn {
                batch.locate(self.tables);
                self.fetch(&mut batch.taps, facets, nearest);
                batch.filter();
                self.light(batch);
            }
            for (i, pixel) in rgb.iter_mut().enumerate() {
                let shaded = std::array::from_fn(|channel| self.tables.encoded(batch.encoded[channel][i]));
                *pixel = if nearest[i] == NO_FACET { self.scene.background } else { shaded };
            }
        }
    }

    /// What the facets are, and the ids; false if there is none.
    #[inline(always)]
    fn planes(
        &self,
        planes: &mut Planes,
        facets: &[Facet],
        [first, row]: [i32; 2],
        nearest: &[u32],
        ids: &mut [u32],
    ) -> bool {
        let mut drawn = false;
        for Run { columns, facet } in runs(nearest) {
            if facet == NO_FACET {
                ids[columns].fill(NO_OBJECT);
                continue;
            }
            drawn = true;
            let facet = &facets[facet as usize];
            let placement = &self.scene.placements[facet.placement as usize];
            ids[columns.clone()].fill(placement.id);
            let rows = facet.varyings.map(|varying| varying.row(row - facet.top));
            let side = placement.model.texture.side() as i32;
            for start in columns.step_by(STRIDE) {
                let span = start..start + STRIDE;
                for (i, column) in planes.column[span.clone()].iter_mut().enumerate() {
                    *column = first - facet.left + (start + i) as i32;
                }
                for (i, varying) in rows.iter().enumerate() {
                    planes.varyings[i][span.clone()].fill(varying.value);
                    planes.per_column[i][span.clone()].fill(varying.per_column);
                }
                for i in 0..2 {
                    planes.per_row[i][span.clone()].fill(facet.varyings[i].per_row);
                }
                planes.nearness[0][span.clone()].fill(facet.inverse_depth.per_column);
                planes.nearness[1][span.clone()].fill(facet.inverse_depth.per_row);
                planes.side[span.clone()].fill(side);
                planes.coarsest[span].fill(side.ilog2() as i32);
            }
        }
        drawn
    }

    #[inline(always)]
    fn fetch(&self, taps: &mut Taps, facets: &[Facet], nearest: &[u32]) {
        for Run { columns, facet } in runs(nearest).filter(|run| run.facet != NO_FACET) {
            let placement = facets[facet as usize].placement as usize;
            let levels = &self.scene.placements[placement].model.texture.levels;
            for i in columns {
                let level = taps.level[i] as usize;
                let fine = &levels[level];
                for tap in 0..4 {
                    taps.texels[0][tap][i] = u32::from_le_bytes(fine[taps.indices[0][tap][i] as usize]);
                }
                if taps.fraction[i] != 0 {
                    let coarse = &levels[level + 1];
                    for tap in 0..4 {
                        taps.texels[1][tap][i] = u32::from_le_bytes(coarse[taps.indices[1][tap][i] as usize]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn light(&self, batch: &mut Batch) {
        let Light { ambient, diffuse, .. } = &self.scene.light;
        for channel in 0..3 {
            for i in 0..BATCH {
                batch.linear[i] = self.tables.linear(batch.albedo[channel][i]);
            }
            for i in 0..BATCH {
                let incidence = batch.taps.incidence[i].max(0.0);
                let linear = batch.linear[i] * (ambient[channel] + diffuse[channel] * incidence);
                batch.encoded[channel][i] = Tables::encoding(linear);
            }
        }
    }
}

/// Pixels being shaded.
#[derive(Debug)]
pub(super) struct Batch {
    inverse_depth: [f32; BATCH],
    planes: Planes,
    place: Place,
    taps: Taps,
    /// Of the finer level and the coarser one, in [`STEPS`] of a level, 16 bits each.
    red_blue: [[u32; BATCH]; 2],
    green: [[u32; BATCH]; 2],
    /// RGB in [`LEVEL_STEPS`] of a level.
    albedo: [[u32; BATCH]; 3],
    linear: [f32; BATCH],
    /// RGB as indices of the encoding table.
    encoded: [[u32; BATCH]; 3],
}

impl Default for Batch {
    fn default() -> Self {
        let zeros = [0.0; BATCH + STRIDE];
        Self {
            inverse_depth: [0.0; BATCH],
            planes: Planes {
                column: [0; BATCH + STRIDE],
                varyings: [zeros; 3],
                per_column: [zeros; 3],
                per_row: [zeros; 2],
                nearness: [zeros; 2],
                side: [1; BATCH + STRIDE],
                coarsest: [0; BATCH + STRIDE],
            },
            place: Place { x: [0; BATCH], y: [0; BATCH], footprint: [0.0; BATCH], detail: [0; BATCH] },
            taps: Taps {
                level: [0; BATCH],
                fraction: [0; BATCH],
                indices: [[[0; BATCH]; 4]; 2],
                weights: [[[0; BATCH]; 4]; 2],
                texels: [[[0; BATCH]; 4]; 2],
                incidence: [0.0; BATCH],
            },
            red_blue: [[0; BATCH]; 2],
            green: [[0; BATCH]; 2],
            albedo: [[0; BATCH]; 3],
            linear: [0.0; BATCH],
            encoded: [[0; BATCH]; 3],
        }
    }
}

impl Batch {
    /// Where the texture is sampled: the coordinates, and the level of detail of the pixel's footprint.
    #[inline(always)]
    fn locate(&mut self, tables: &Tables) {
        let Self { planes, taps, place, .. } = self;
        for i in 0..BATCH {
            let depth = 1.0 / self.inverse_depth[i];
            let column = planes.column[i] as f32;
            let at = |varying: usize| {
                (planes.varyings[varying][i] + planes.per_column[varying][i] * column) * depth
            };
            let (u, v) = (at(0), at(1));
            taps.incidence[i] = at(2);
            let squared = |over_u: f32, over_v: f32, nearness: f32| {
                let (u, v) = (over_u - u * nearness, over_v - v * nearness);
                u * u + v * v
            };
            let along_row = squared(planes.per_column[0][i], planes.per_column[1][i], planes.nearness[0][i]);
            let along_column = squared(planes.per_row[0][i], planes.per_row[1][i], planes.nearness[1][i]);
            let side = planes.side[i] as f32;
            let texels = depth * side;
            place.footprint[i] =
                if along_row > along_column { along_row } else { along_column } * (texels * texels);
            let steps = side * STEPS as f32;
            place.x[i] = round_small(u * steps);
            place.y[i] = round_small(v * steps);
        }
        for i in 0..BATCH {
            place.detail[i] = tables.half_log2(place.footprint[i]);
        }
        for i in 0..BATCH {
            let detail = place.detail[i].clamp(0, planes.coarsest[i] * STEPS);
            taps.level[i] = detail >> 8;
            taps.fraction[i] = (detail & 255) as u32;
        }
        for which in 0..2 {
            let (indices, weights) = (&mut taps.indices[which], &mut taps.weights[which]);
            for i in 0..BATCH {
                let coarsest = planes.coarsest[i];
                let level = (taps.level[i] + which as i32).min(coarsest) & 31;
                let (x, y) = (
                    (place.x[i] >> level).wrapping_sub(STEPS / 2),
                    (place.y[i] >> level).wrapping_sub(STEPS / 2),
                );
                let shift = (coarsest - level) & 31;
                let last = (1 << shift) - 1;
                let (left, right) = ((x >> 8) & last, ((x >> 8) + 1) & last);
                let (top, bottom) = (((y >> 8) & last) << shift, (((y >> 8) + 1) & last) << shift);
                let (fx, fy) = ((x & 255) as u32, (y & 255) as u32);
                let both = (fx * fy) >> 8;
                indices[0][i] = (top + left) as u32;
                indices[1][i] = (top + right) as u32;
                indices[2][i] = (bottom + left) as u32;
                indices[3][i] = (bottom + right) as u32;
                weights[0][i] = STEPS as u32 + both - fx - fy;
                weights[1][i] = fx - both;
                weights[2][i] = fy - both;
                weights[3][i] = both;
            }
        }
    }

    /// Mixes the texels.
    #[inline(always)]
    fn filter(&mut self) {
        // Red and blue go together, in 16 bits each.
        const PAIR: u32 = 0x00ff_00ff;
        for which in 0..2 {
            let (texels, weights) = (&self.taps.texels[which], &self.taps.weights[which]);
            for i in 0..BATCH {
                let red_blue = |tap: usize| (texels[tap][i] & PAIR) * weights[tap][i];
                let green = |tap: usize| ((texels[tap][i] >> 8) & 0xff) * weights[tap][i];
                self.red_blue[which][i] = red_blue(0) + red_blue(1) + red_blue(2) + red_blue(3);
                self.green[which][i] = green(0) + green(1) + green(2) + green(3);
            }
        }
        for i in 0..BATCH {
            let fraction = self.taps.fraction[i];
            let mixed = |fine: u32, coarse: u32| {
                let rounded = |pair: u32| ((pair + 0x0080_0080) >> 8) & PAIR;
                let mixed = rounded(fine) * (STEPS as u32 - fraction) + rounded(coarse) * fraction;
                if fraction == 0 { fine } else { mixed }
            };
            let red_blue = mixed(self.red_blue[0][i], self.red_blue[1][i]);
            let green = mixed(self.green[0][i], self.green[1][i]);
            let levels = |steps: u32| {
                (steps + STEPS as u32 / LEVEL_STEPS as u32 / 2) / (STEPS as u32 / LEVEL_STEPS as u32)
            };
            self.albedo[0][i] = levels(red_blue & 0xffff);
            self.albedo[1][i] = levels(green);
            self.albedo[2][i] = levels(red_blue >> 16);
        }
    }
}

/// The runs of a batch's pixels.
#[inline(always)]
fn runs(nearest: &[u32]) -> impl Iterator<Item = Run> + '_ {
    let mut start = 0;
    nearest.chunk_by(PartialEq::eq).map(move |run| {
        let columns = start..start + run.len();
        start = columns.end;
        Run { columns, facet: run[0] }
    })
}
