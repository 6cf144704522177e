//! The canvas of one texture, and patches of it.

use super::region::{Area, GUTTER, Region};
use super::{Rgb, mix};
use crate::texture::{TEXTURE_SIDE, Texture};

/// The texels of one texture.
#[derive(Clone, Debug)]
pub(crate) struct Canvas {
    texels: Vec<Rgb>,
}

impl Canvas {
    /// One colour everywhere.
    pub fn new(colour: Rgb) -> Self {
        Self { texels: vec![colour; TEXTURE_SIDE * TEXTURE_SIDE] }
    }

    /// Paints a region whose surface is `size` = `[width, height]` metres on average.
    pub fn paint(&mut self, region: Region, size: [f64; 2], draw: impl FnOnce(&mut Patch<'_>)) {
        self.fill_region(region, size, false, draw);
    }

    /// Paints a region whose left and right borders meet on the surface: marks may run over the seam.
    pub fn wrap(&mut self, region: Region, size: [f64; 2], draw: impl FnOnce(&mut Patch<'_>)) {
        self.fill_region(region, size, true, draw);
    }

    /// One colour all over a region.
    pub fn plain(&mut self, region: Region, colour: Rgb) {
        self.paint(region, [1.0, 1.0], |patch| patch.fill(colour));
    }

    fn fill_region(
        &mut self,
        region: Region,
        size: [f64; 2],
        wraps: bool,
        draw: impl FnOnce(&mut Patch<'_>),
    ) {
        draw(&mut Patch { canvas: self, region, aspect: size[0] / size[1], wraps });
        let [width, height] = region.inner();
        for row in 0..region.height {
            let from_row = row.clamp(GUTTER, GUTTER + height - 1);
            for column in 0..region.width {
                let from_column = if wraps {
                    (column + width - GUTTER) % width + GUTTER
                } else {
                    column.clamp(GUTTER, GUTTER + width - 1)
                };
                let from = (region.row + from_row) * TEXTURE_SIDE + region.column + from_column;
                self.texels[(region.row + row) * TEXTURE_SIDE + region.column + column] = self.texels[from];
            }
        }
    }

    /// The texture, rounded to 8 bits.
    pub fn to_texture(&self) -> Texture {
        let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        Texture::new(self.texels.iter().map(|c| [byte(c[0]), byte(c[1]), byte(c[2]), 255]).collect())
    }
}

/// A part of a canvas under the brush, in shares of its width and height.
#[derive(Debug)]
pub(crate) struct Patch<'a> {
    canvas: &'a mut Canvas,
    region: Region,
    aspect: f64,
    wraps: bool,
}

impl Patch<'_> {
    /// Width over height on the surface.
    pub fn aspect(&self) -> f64 {
        self.aspect
    }

    /// True where left and right borders meet.
    pub fn wraps(&self) -> bool {
        self.wraps
    }

    /// The area about a centre that is square on the surface, with half its height given.
    pub fn square(&self, center: [f64; 2], half_height: f64) -> Area {
        Area::around(center, [half_height / self.aspect, half_height])
    }

    /// The largest area in the middle of `area` that is square on the surface.
    pub fn square_in(&self, area: Area) -> Area {
        self.square(area.center(), 0.5 * area.height().min(area.width() * self.aspect))
    }

    /// Draws over `area`, of which `colour` sees the coordinates `(p, q)` in `[-1, 1]`, q downwards; `None` leaves
    /// what is there. Four samples a texel.
    pub fn draw(&mut self, area: Area, colour: impl Fn(f64, f64) -> Option<Rgb>) {
        let [width, height] = self.region.inner();
        let first = |low: f64, size: usize| libm::floor(low * size as f64) as isize;
        let end = |high: f64, size: usize| libm::ceil(high * size as f64) as isize;
        let rows = first(area.t[0], height).max(0)..end(area.t[1], height).min(height as isize);
        let (mut left, mut right) = (first(area.s[0], width), end(area.s[1], width));
        if !self.wraps || right - left > width as isize {
            (left, right) = (left.max(0), right.min(width as isize));
        }
        let local = |texel: f64, size: usize, range: [f64; 2]| {
            2.0 * (texel / size as f64 - range[0]) / (range[1] - range[0]) - 1.0
        };
        for row in rows {
            let q = [0.25, 0.75].map(|part| local(row as f64 + part, height, area.t));
            for column in left..right {
                let p = [0.25, 0.75].map(|part| local(column as f64 + part, width, area.s));
                let inside = column.rem_euclid(width as isize) as usize;
                let index = (self.region.row + GUTTER + row as usize) * TEXTURE_SIDE
                    + self.region.column
                    + GUTTER
                    + inside;
                let ground = self.canvas.texels[index];
                let mut sum = [0.0; 3];
                for (p, q) in [(p[0], q[0]), (p[1], q[0]), (p[0], q[1]), (p[1], q[1])] {
                    let hit = p.abs() <= 1.0 && q.abs() <= 1.0;
                    let sample = if hit { colour(p, q) } else { None }.unwrap_or(ground);
                    (0..3).for_each(|channel| sum[channel] += 0.25 * sample[channel]);
                }
                self.canvas.texels[index] = sum;
            }
        }
    }

    /// One colour all over the patch.
    pub fn fill(&mut self, colour: Rgb) {
        self.draw(Area::ALL, |_, _| Some(colour));
    }

    /// A filled rectangle.
    pub fn rect(&mut self, area: Area, colour: Rgb) {
        self.draw(area, |_, _| Some(colour));
    }

    /// A filled ellipse.
    pub fn disc(&mut self, area: Area, colour: Rgb) {
        self.draw(area, |p, q| (p * p + q * q <= 1.0).then_some(colour));
    }

    /// From one colour at the top to another at the bottom.
    pub fn fade(&mut self, area: Area, top: Rgb, bottom: Rgb) {
        self.draw(area, |_, q| Some(mix(top, bottom, 0.5 + 0.5 * q)));
    }

    /// Makes a square patch equal to itself turned by a quarter, by repeating its upper left quarter.
    pub fn repeat_quarters(&mut self) {
        let [side, _] = self.region.inner();
        let at = |row: usize, column: usize| {
            (self.region.row + GUTTER + row) * TEXTURE_SIDE + self.region.column + GUTTER + column
        };
        for row in 0..side / 2 {
            for column in 0..side / 2 {
                let colour = self.canvas.texels[at(row, column)];
                self.canvas.texels[at(column, side - 1 - row)] = colour;
                self.canvas.texels[at(side - 1 - row, side - 1 - column)] = colour;
                self.canvas.texels[at(side - 1 - column, row)] = colour;
            }
        }
    }
}
