//! Colour of each pixel: filtered albedo under light.
//!
//! Pixels are shaded in batches, step by step, so that the compiler can do several at once.

use super::super::{Light, NO_OBJECT, RenderScene};
use super::canvas::NO_FACET;
use super::raster::Facet;
use super::runs::{BATCH, Run, Runs};
use super::tables::{TABLES, TOE, Tables, round_small};
use crate::texture::first_texel;

/// Steps of a texel.
const STEPS: i32 = 256;

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
    id: Lanes<u32>,
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
    /// Coarsest level of the texture.
    coarsest: Lanes<i32>,
}

/// What is sampled.
#[derive(Debug)]
struct Taps {
    /// Of the top left, top right, bottom left and bottom right texel, among those of all levels.
    indices: [[u32; BATCH]; 4],
    /// Likewise, in [`STEPS`].
    weights: [[u32; BATCH]; 4],
    texels: [[u32; BATCH]; 4],
    incidence: [f32; BATCH],
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
            let runs = Runs::of(nearest);
            if runs.all_empty() {
                ids.fill(NO_OBJECT);
                rgb.fill(self.scene.background);
                continue;
            }
            batch.inverse_depth[..nearest.len()].copy_from_slice(inverse_depth);
            self.planes(&mut batch.planes, facets, [first, row], runs);
            ids.copy_from_slice(&batch.planes.id[..ids.len()]);
            batch.locate();
            self.fetch(&mut batch.taps, facets, runs);
            self.light(batch);
            for ((pixel, &shaded), &facet) in rgb.iter_mut().zip(&batch.rgb).zip(nearest) {
                let [r, g, b, _] = shaded.to_le_bytes();
                *pixel = if facet == NO_FACET { self.scene.background } else { [r, g, b] };
            }
        }
    }

    /// What the facets are.
    #[inline(always)]
    fn planes(&self, planes: &mut Planes, facets: &[Facet], [first, row]: [i32; 2], runs: Runs<'_>) {
        for Run { columns, facet } in runs.iter() {
            if facet == NO_FACET {
                for start in columns.step_by(STRIDE) {
                    planes.id[start..start + STRIDE].fill(NO_OBJECT);
                }
                continue;
            }
            let facet = facets[facet as usize];
            let placement = &self.scene.placements[facet.placement as usize];
            let left = first - facet.left;
            let rows = facet.varyings.map(|varying| varying.row(row - facet.top));
            let coarsest = placement.model.texture.coarsest() as i32;
            for start in columns.step_by(STRIDE) {
                let span = start..start + STRIDE;
                planes.id[span.clone()].fill(placement.id);
                for (i, column) in planes.column[span.clone()].iter_mut().enumerate() {
                    *column = left + (start + i) as i32;
                }
                for (i, row) in rows.iter().enumerate() {
                    planes.varyings[i][span.clone()].fill(row.value);
                    planes.per_column[i][span.clone()].fill(row.per_column);
                }
                for i in 0..2 {
                    planes.per_row[i][span.clone()].fill(facet.varyings[i].per_row);
                }
                planes.nearness[0][span.clone()].fill(facet.inverse_depth.per_column);
                planes.nearness[1][span.clone()].fill(facet.inverse_depth.per_row);
                planes.coarsest[span].fill(coarsest);
            }
        }
    }

    #[inline(always)]
    fn fetch(&self, taps: &mut Taps, facets: &[Facet], runs: Runs<'_>) {
        for Run { columns, facet } in runs.iter().filter(|run| run.facet != NO_FACET) {
            let placement = facets[facet as usize].placement as usize;
            let texels = self.scene.placements[placement].model.texture.texels();
            let [a, b, c, d] = taps.texels.each_mut().map(|taken| &mut taken[columns.clone()]);
            let [at_a, at_b, at_c, at_d] = taps.indices.each_ref().map(|indices| &indices[columns.clone()]);
            let texel = |index: u32| u32::from_le_bytes(texels[index as usize]);
            for i in 0..columns.len() {
                (a[i], b[i], c[i], d[i]) = (texel(at_a[i]), texel(at_b[i]), texel(at_c[i]), texel(at_d[i]));
            }
        }
    }

    /// Mixes the texels and lights them; see [`Tables::gain`].
    #[inline(always)]
    fn light(&self, batch: &mut Batch) {
        // Red and blue go together, in 16 bits each.
        const PAIR: u32 = 0x00ff_00ff;
        const LEVEL: f32 = 1.0 / STEPS as f32;
        let Light { ambient, diffuse, .. } = &self.scene.light;
        let Batch { taps, irradiance, gain, rgb, .. } = batch;
        for channel in 0..3 {
            for (sum, incidence) in irradiance[channel].iter_mut().zip(&taps.incidence) {
                *sum = ambient[channel] + diffuse[channel] * incidence.max(0.0);
            }
            for i in 0..BATCH {
                gain[channel][i] = self.tables.gain(irradiance[channel][i]);
            }
        }
        for i in 0..BATCH {
            let red_blue = |tap: usize| (taps.texels[tap][i] & PAIR) * taps.weights[tap][i];
            let green = |tap: usize| ((taps.texels[tap][i] >> 8) & 0xff) * taps.weights[tap][i];
            let red_blue = red_blue(0) + red_blue(1) + red_blue(2) + red_blue(3);
            let green = green(0) + green(1) + green(2) + green(3);
            let lit = |channel: usize, albedo: u32| {
                let (albedo, irradiance) = (albedo as i32 as f32 * LEVEL, irradiance[channel][i]);
                let (curve, line) = ((albedo + TOE) * gain[channel][i] - TOE, albedo * irradiance);
                let (low, high) = if curve < line { (curve, line) } else { (line, curve) };
                round_small(if irradiance > 1.0 { low } else { high }.clamp(0.0, 255.0)) as u32
            };
            rgb[i] = lit(0, red_blue & 0xffff) | lit(1, green) << 8 | lit(2, red_blue >> 16) << 16;
        }
    }
}

/// Pixels being shaded.
#[derive(Debug)]
pub(super) struct Batch {
    inverse_depth: [f32; BATCH],
    planes: Planes,
    taps: Taps,
    irradiance: [[f32; BATCH]; 3],
    gain: [[f32; BATCH]; 3],
    /// sRGB, a byte each, red lowest.
    rgb: [u32; BATCH],
}

impl Default for Batch {
    fn default() -> Self {
        let zeros = [0.0; BATCH + STRIDE];
        Self {
            inverse_depth: [0.0; BATCH],
            planes: Planes {
                id: [NO_OBJECT; BATCH + STRIDE],
                column: [0; BATCH + STRIDE],
                varyings: [zeros; 3],
                per_column: [zeros; 3],
                per_row: [zeros; 2],
                nearness: [zeros; 2],
                coarsest: [0; BATCH + STRIDE],
            },
            taps: Taps {
                indices: [[0; BATCH]; 4],
                weights: [[0; BATCH]; 4],
                texels: [[0; BATCH]; 4],
                incidence: [0.0; BATCH],
            },
            irradiance: [[0.0; BATCH]; 3],
            gain: [[0.0; BATCH]; 3],
            rgb: [0; BATCH],
        }
    }
}

impl Batch {
    /// Where the texture is sampled: the coordinates, in the level whose texels are nearest in size to the pixel's footprint.
    #[inline(always)]
    fn locate(&mut self) {
        let Self { planes, taps, .. } = self;
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
            let coarsest = planes.coarsest[i];
            let side = power_of_two(coarsest);
            let texels = depth * side;
            // Square of the pixel's extent in texels of the finest level: between 2^(2l - 1) and 2^(2l + 1) at level l.
            let footprint =
                if along_row > along_column { along_row } else { along_column } * (texels * texels);
            let exponent = (footprint.to_bits() >> 23) as i32 - 127;
            let level = ((exponent + 1) >> 1).max(0).min(coarsest) & 31;
            let steps = side * STEPS as f32;
            let place = |coordinate: f32| (round_small(coordinate * steps) >> level).wrapping_sub(STEPS / 2);
            let (x, y) = (place(u), place(v));
            let shift = (coarsest - level) & 31;
            let last = (1 << shift) - 1;
            let (left, right) = ((x >> 8) & last, ((x >> 8) + 1) & last);
            let first = first_texel(shift as u32) as i32;
            let (top, bottom) =
                (first + (((y >> 8) & last) << shift), first + ((((y >> 8) + 1) & last) << shift));
            let (fx, fy) = ((x & 255) as u32, (y & 255) as u32);
            let both = (fx * fy) >> 8;
            taps.indices[0][i] = (top + left) as u32;
            taps.indices[1][i] = (top + right) as u32;
            taps.indices[2][i] = (bottom + left) as u32;
            taps.indices[3][i] = (bottom + right) as u32;
            taps.weights[0][i] = STEPS as u32 + both - fx - fy;
            taps.weights[1][i] = fx - both;
            taps.weights[2][i] = fy - both;
            taps.weights[3][i] = both;
        }
    }
}

#[inline(always)]
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) << 23) as u32)
}
