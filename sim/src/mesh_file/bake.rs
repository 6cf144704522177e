//! All materials of a mesh in one texture.

use super::atlas::{Rect, layout};
use super::soup::{Material, Wrap};
use super::surface::Facet;
use super::{MeshFault, color};
use crate::texture::{TEXTURE_SIDES, Texture};
use image::RgbImage;
use image::imageops::{FilterType, resize};
use std::borrow::Cow;

/// Side of a baked texture, texels: the largest there is.
const SIDE: usize = *TEXTURE_SIDES.end();
/// Texels around a material that its triangles do not reach, so that filtering stays among its own colours.
const MARGIN: usize = 2;
/// Most looks that one texture holds.
const MAX_LOOKS: usize = 64;
/// Each look gets at least this share of the texture of one with all the area.
const LEAST_SHARE: f64 = 1.0 / 64.0;
/// Samples along a side of a texel: at least for the outlines of triangles, at most for the detail of an image.
const SAMPLES: [usize; 2] = [2, 8];
/// Where triangles cover their part of the image this often, all of it is taken for covered.
const MAX_COVERS: usize = 32;

/// Bakes the looks and moves the texture coordinates of the facets to where they went.
pub(crate) fn bake(
    facets: &mut [Facet],
    materials: &[Material],
    images: &[RgbImage],
) -> Result<Texture, MeshFault> {
    let looks = looks(facets, materials);
    if looks.len() > MAX_LOOKS {
        return Err(MeshFault::TooMany { what: "materials", got: looks.len(), limit: MAX_LOOKS });
    }
    let total: f64 = looks.iter().map(|look| look.area).sum();
    let weights: Vec<f64> = looks
        .iter()
        .map(|look| if look.material.image.is_some() { look.area / total } else { 0.0 }.max(LEAST_SHARE))
        .collect();
    let mut canvas = vec![None; SIDE * SIDE];
    for (look, rect) in looks.iter().zip(layout(SIDE, &weights)) {
        let inner = Rect {
            x: rect.x + MARGIN,
            y: rect.y + MARGIN,
            width: rect.width.saturating_sub(2 * MARGIN).max(1),
            height: rect.height.saturating_sub(2 * MARGIN).max(1),
        };
        match look.material.image {
            None => {
                let texel = look.material.color.map(|channel| (255.0 * color::encoded(channel)).round());
                rows(&rect).for_each(|row| canvas[row].fill(Some(texel)));
                let center =
                    [rect.x as f64 + rect.width as f64 / 2.0, rect.y as f64 + rect.height as f64 / 2.0];
                let uv = center.map(|at| at / SIDE as f64);
                look.facets.iter().for_each(|&i| facets[i].uvs = [uv; 3]);
            }
            Some(image) => {
                let window = window(facets, look, &images[image]);
                let tile = Tile { window, width: inner.width, height: inner.height };
                for (row, texels) in rows(&inner).zip(tile.resample(facets, look, &images[image])) {
                    canvas[row].copy_from_slice(&texels);
                }
                let corner = [inner.x as f64, inner.y as f64];
                for &i in &look.facets {
                    facets[i].uvs = facets[i].uvs.map(|uv| {
                        let at = tile.texel(uv);
                        [0, 1].map(|axis| (corner[axis] + at[axis]) / SIDE as f64)
                    });
                }
            }
        }
    }
    Ok(Texture::new(filled(canvas)))
}

/// What looks alike, and which facets do.
struct Look<'a> {
    material: &'a Material,
    facets: Vec<usize>,
    /// Square metres, twice.
    area: f64,
}

/// The looks that facets have, in their order.
fn looks<'a>(facets: &[Facet], materials: &'a [Material]) -> Vec<Look<'a>> {
    let alike = |a: &Material, b: &Material| {
        a.image == b.image && a.color == b.color && (a.image.is_none() || a.wrap == b.wrap)
    };
    let mut looks: Vec<Look<'a>> = Vec::new();
    // Materials are few, but as many as facets in a hostile file.
    let mut look_of: Vec<Option<usize>> = vec![None; materials.len()];
    for (i, facet) in facets.iter().enumerate() {
        let look = *look_of[facet.material].get_or_insert_with(|| {
            let material = &materials[facet.material];
            let known = looks.iter().take(MAX_LOOKS).position(|look| alike(look.material, material));
            known.unwrap_or_else(|| {
                looks.push(Look { material, facets: Vec::new(), area: 0.0 });
                looks.len() - 1
            })
        });
        looks[look].facets.push(i);
        looks[look].area += facet.area().norm();
    }
    looks
}

fn rows(rect: &Rect) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
    let Rect { x, y, width, height } = *rect;
    (y..y + height).map(move |row| row * SIDE + x..row * SIDE + x + width)
}

/// Moves each facet by whole periods to where its image begins, and returns the range that all of them span.
fn window(facets: &mut [Facet], look: &Look<'_>, image: &RgbImage) -> [[f64; 2]; 2] {
    let size = [image.width(), image.height()].map(f64::from);
    [0, 1].map(|axis| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &i in &look.facets {
            let uvs = &mut facets[i].uvs;
            let first = uvs.iter().map(|uv| uv[axis]).fold(f64::INFINITY, f64::min);
            if let Some(period) = look.material.wrap[axis].period() {
                let shift = period * (first / period).floor();
                uvs.iter_mut().for_each(|uv| uv[axis] -= shift);
            }
            for uv in uvs {
                low = low.min(uv[axis]);
                high = high.max(uv[axis]);
            }
        }
        // At least the pixel around a single point.
        let missing = (1.0 / size[axis] - (high - low)).max(0.0);
        [low - missing / 2.0, high + missing / 2.0]
    })
}

/// A part of the texture, and the window of the endless image that is seen in it.
struct Tile {
    /// Lowest and highest u, then v.
    window: [[f64; 2]; 2],
    /// Texels.
    width: usize,
    height: usize,
}

impl Tile {
    /// Where an image coordinate is in the tile, texels.
    fn texel(&self, uv: [f64; 2]) -> [f64; 2] {
        let size = [self.width as f64, self.height as f64];
        [0, 1].map(|axis| {
            let [low, high] = self.window[axis];
            (uv[axis] - low) / (high - low) * size[axis]
        })
    }

    /// The mean, sRGB-encoded colour of what triangles show of each texel, row by row.
    fn resample(&self, facets: &[Facet], look: &Look<'_>, image: &RgbImage) -> Vec<Vec<Option<[f32; 3]>>> {
        let spans = self.window.map(|[low, high]| high - low);
        let size = [f64::from(image.width()), f64::from(image.height())];
        let texels = [self.width as f64, self.height as f64];
        let pixels = [0, 1].map(|axis| size[axis] * spans[axis] / texels[axis]);
        let samples = (pixels[0].max(pixels[1]).ceil() as usize).clamp(SAMPLES[0], SAMPLES[1]);
        // A finer image would be picked from, not averaged.
        let wanted = [0, 1].map(|axis| {
            let finest = (samples as f64 * texels[axis] / spans[axis]).ceil().max(1.0);
            finest.min(size[axis]) as u32
        });
        let image = if wanted == [image.width(), image.height()] {
            Cow::Borrowed(image)
        } else {
            Cow::Owned(resize(image, wanted[0], wanted[1], FilterType::Triangle))
        };
        let covered = self.cover(facets, look, samples);
        let tint = |color| tinted(color, look.material.color);
        (0..self.height)
            .map(|y| {
                let texel = |x: usize| {
                    let (mut sum, mut count) = ([0.0; 3], 0u32);
                    for (j, i) in (0..samples).flat_map(|j| (0..samples).map(move |i| (j, i))) {
                        let (row, column) = (y * samples + j, x * samples + i);
                        if covered[row * self.width * samples + column] {
                            let at = [column, row].map(|at| (at as f64 + 0.5) / samples as f64);
                            let pixel = self.sample(&image, at, look.material.wrap);
                            (0..3).for_each(|channel| sum[channel] += pixel[channel]);
                            count += 1;
                        }
                    }
                    (count > 0).then(|| tint(sum.map(|channel| channel / count as f32)))
                };
                (0..self.width).map(texel).collect()
            })
            .collect()
    }

    /// The endless image at a place in the tile, between its four nearest pixels.
    fn sample(&self, image: &RgbImage, at: [f64; 2], wrap: [Wrap; 2]) -> [f32; 3] {
        let (size, texels) = ([image.width(), image.height()], [self.width as f64, self.height as f64]);
        let [(x, across), (y, down)] = [0, 1].map(|axis| {
            let [low, high] = self.window[axis];
            let pixel = (low + at[axis] / texels[axis] * (high - low)) * f64::from(size[axis]) - 0.5;
            (pixel.floor() as i64, (pixel - pixel.floor()) as f32)
        });
        let pixel = |x: i64, y: i64| {
            image.get_pixel(wrap[0].pixel(x, size[0]), wrap[1].pixel(y, size[1])).0.map(f32::from)
        };
        let [a, b, c, d] = [pixel(x, y), pixel(x + 1, y), pixel(x, y + 1), pixel(x + 1, y + 1)];
        std::array::from_fn(|i| {
            let (upper, lower) = (a[i] + (b[i] - a[i]) * across, c[i] + (d[i] - c[i]) * across);
            upper + (lower - upper) * down
        })
    }

    /// Which samples triangles touch, row by row.
    fn cover(&self, facets: &[Facet], look: &Look<'_>, samples: usize) -> Vec<bool> {
        let (width, height) = (self.width * samples, self.height * samples);
        let mut covered = vec![false; width * height];
        let mut work = 0;
        for &i in &look.facets {
            let corners = facets[i].uvs.map(|uv| self.texel(uv).map(|at| at * samples as f64));
            let rows = corners.map(|[_, y]| y);
            let (top, bottom) = (rows[0].min(rows[1]).min(rows[2]), rows[0].max(rows[1]).max(rows[2]));
            for row in cells(top, bottom, height) {
                let y = (row as f64 + 0.5).clamp(top, bottom);
                let (left, right) = crossing(&corners, y);
                let columns = cells(left, right, width);
                work += columns.len() + 1;
                covered[row * width..][columns].fill(true);
            }
            if work > MAX_COVERS * covered.len() {
                covered.fill(true);
                break;
            }
        }
        covered
    }
}

/// The cells from `low` to `high`, of `count`.
fn cells(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    let cell = |at: f64| (at.max(0.0) as usize).min(count - 1);
    cell(low)..cell(high) + 1
}

/// From where to where a triangle reaches at the height `y`, which it has.
fn crossing(corners: &[[f64; 2]; 3], y: f64) -> (f64, f64) {
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(from, to)| (corners[from], corners[to]));
    let mut reach = (f64::INFINITY, f64::NEG_INFINITY);
    for (from, to) in edges {
        let (low, high) = if from[1] <= to[1] { (from, to) } else { (to, from) };
        if (low[1]..=high[1]).contains(&y) {
            let rise = high[1] - low[1];
            let ends = if rise > 0.0 {
                let x = low[0] + (y - low[1]) / rise * (high[0] - low[0]);
                [x, x]
            } else {
                [low[0], high[0]]
            };
            for x in ends {
                reach = (reach.0.min(x), reach.1.max(x));
            }
        }
    }
    reach
}

/// An sRGB-encoded colour, 0 to 255, times a linear factor.
fn tinted(color: [f32; 3], factor: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| {
        if factor[i] == 1.0 {
            color[i]
        } else {
            255.0 * color::encoded(color::linear(color[i] / 255.0) * factor[i])
        }
    })
}

/// Fills the texels that no triangle shows with the colours around them, as coarse as the gap is wide.
fn filled(canvas: Vec<Option<[f32; 3]>>) -> Vec<[u8; 4]> {
    let mut levels = vec![canvas];
    let mut side = SIDE;
    while side > 1 {
        let fine = &levels[levels.len() - 1];
        side /= 2;
        let coarse = (0..side * side)
            .map(|i| {
                let corner = 2 * (i / side) * 2 * side + 2 * (i % side);
                let four = [corner, corner + 1, corner + 2 * side, corner + 2 * side + 1];
                let known: Vec<[f32; 3]> = four.iter().filter_map(|&i| fine[i]).collect();
                let mean = |channel: usize| {
                    known.iter().map(|color| color[channel]).sum::<f32>() / known.len() as f32
                };
                (!known.is_empty()).then(|| std::array::from_fn(mean))
            })
            .collect();
        levels.push(coarse);
    }
    while let [.., fine, coarse] = levels.as_mut_slice() {
        for (i, texel) in fine.iter_mut().enumerate() {
            let (row, column) = (i / (2 * side), i % (2 * side));
            *texel = texel.or(coarse[row / 2 * side + column / 2]);
        }
        levels.pop();
        side *= 2;
    }
    let byte = |channel: f32| channel.round().clamp(0.0, 255.0) as u8;
    levels[0]
        .iter()
        .map(|texel| texel.unwrap_or_default().map(byte))
        .map(|[r, g, b]| [r, g, b, 255])
        .collect()
}
