//! Procedural textures of floors, walls and tables.

use crate::texture::{TEXTURE_SIDE, Texture};
use vantage_dataset::Stream;

/// Cells along each side of the coarsest noise; the noise wraps, so that panels join without a seam.
const CELLS: usize = 4;

/// Draws a texture: one of plaster, planks, tiles or speckles, in one muted colour.
pub fn draw(stream: &mut Stream) -> Texture {
    let color = muted_color(stream);
    let clouds = Noise::draw(CELLS, stream);
    let grain = Noise::draw(TEXTURE_SIDE, stream);
    let contrast = stream.uniform(0.15, 0.45);
    let stripes = 3 + stream.below(6);
    let kind = stream.below(4);
    let texel = |x: usize, y: usize| {
        let (u, v) = (x as f64 / TEXTURE_SIDE as f64, y as f64 / TEXTURE_SIDE as f64);
        let fine = grain.at(u, v) - 0.5;
        let coarse = clouds.at(u, v) - 0.5;
        let (stripe, row) = ((u * stripes as f64) as usize, (v * stripes as f64) as usize);
        let edge = |t: f64| (t * stripes as f64).fract() < 0.05;
        let shade = match kind {
            0 => coarse + 0.2 * fine,
            1 if edge(u) => -0.8,
            1 => clouds.cell(stripe, 0) - 0.5 + 0.5 * (grain.at(u, v / 16.0) - 0.5),
            2 if edge(u) || edge(v) => 0.6,
            2 => clouds.cell(stripe, row) - 0.5 + 0.1 * fine,
            _ => 0.4 * coarse + fine,
        };
        let scale = 1.0 + contrast * shade;
        let [r, g, b] = color.map(|channel| (255.0 * channel * scale).clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    };
    Texture::new(
        (0..TEXTURE_SIDE * TEXTURE_SIDE).map(|i| texel(i % TEXTURE_SIDE, i / TEXTURE_SIDE)).collect(),
    )
}

fn muted_color(stream: &mut Stream) -> [f64; 3] {
    let grey = stream.uniform(0.35, 0.8);
    std::array::from_fn(|_| grey * stream.uniform(0.75, 1.2))
}

/// Smooth noise in `[0, 1]` on a square that wraps.
struct Noise {
    cells: usize,
    values: Vec<f64>,
}

impl Noise {
    fn draw(cells: usize, stream: &mut Stream) -> Self {
        Self { cells, values: (0..cells * cells).map(|_| stream.unit()).collect() }
    }

    fn cell(&self, x: usize, y: usize) -> f64 {
        self.values[(y % self.cells) * self.cells + x % self.cells]
    }

    fn at(&self, u: f64, v: f64) -> f64 {
        let (x, y) = (u * self.cells as f64, v * self.cells as f64);
        let (column, row) = (x as usize, y as usize);
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        let (a, b) = (smooth(x.fract()), smooth(y.fract()));
        let top = self.cell(column, row) * (1.0 - a) + self.cell(column + 1, row) * a;
        let bottom = self.cell(column, row + 1) * (1.0 - a) + self.cell(column + 1, row + 1) * a;
        top * (1.0 - b) + bottom * b
    }
}
