//! Rectangles: of the texture, and of a patch painted into it.

use crate::texture::TEXTURE_SIDE;

/// Texels around a region that repeat its border, so that filtering does not draw in the neighbour.
pub(crate) const GUTTER: usize = 2;

/// A rectangle of the texture, texels, its gutter included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub column: usize,
    pub row: usize,
    pub width: usize,
    pub height: usize,
}

impl Region {
    /// The rectangle with its upper left texel at `(column, row)`.
    pub const fn new(column: usize, row: usize, width: usize, height: usize) -> Self {
        assert!(column + width <= TEXTURE_SIDE && row + height <= TEXTURE_SIDE);
        assert!(width > 2 * GUTTER && height > 2 * GUTTER);
        Self { column, row, width, height }
    }

    /// Columns and rows inside the gutter.
    pub fn inner(&self) -> [usize; 2] {
        [self.width - 2 * GUTTER, self.height - 2 * GUTTER]
    }

    /// Texture coordinates of the point at shares `s` (rightwards) and `t` (downwards) of the inside.
    pub fn uv(&self, s: f64, t: f64) -> [f64; 2] {
        let [width, height] = self.inner();
        let side = TEXTURE_SIDE as f64;
        [
            ((self.column + GUTTER) as f64 + s.clamp(0.0, 1.0) * width as f64) / side,
            ((self.row + GUTTER) as f64 + t.clamp(0.0, 1.0) * height as f64) / side,
        ]
    }
}

/// A rectangle of a patch, in shares of its width and height, t downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    /// Left and right.
    pub s: [f64; 2],
    /// Top and bottom.
    pub t: [f64; 2],
}

impl Area {
    /// The whole patch.
    pub const ALL: Area = Area { s: [0.0, 1.0], t: [0.0, 1.0] };

    /// Between left, top, right and bottom.
    pub fn new(left: f64, top: f64, right: f64, bottom: f64) -> Self {
        Self { s: [left, right], t: [top, bottom] }
    }

    /// About a centre, with half sizes.
    pub fn around([s, t]: [f64; 2], [half_width, half_height]: [f64; 2]) -> Self {
        Self::new(s - half_width, t - half_height, s + half_width, t + half_height)
    }

    /// Between the heights `top` and `bottom`, over the full width.
    pub fn band(top: f64, bottom: f64) -> Self {
        Self::new(0.0, top, 1.0, bottom)
    }

    pub fn width(&self) -> f64 {
        self.s[1] - self.s[0]
    }

    pub fn height(&self) -> f64 {
        self.t[1] - self.t[0]
    }

    pub fn center(&self) -> [f64; 2] {
        [0.5 * (self.s[0] + self.s[1]), 0.5 * (self.t[0] + self.t[1])]
    }

    /// The part of this area given in shares of it.
    pub fn part(&self, left: f64, top: f64, right: f64, bottom: f64) -> Self {
        let at = |range: [f64; 2], share: f64| range[0] + share * (range[1] - range[0]);
        Self::new(at(self.s, left), at(self.t, top), at(self.s, right), at(self.t, bottom))
    }
}
