//! Which pixels a triangle covers, and what varies over it.

use super::view::SUBPIXELS;
use std::ops::Range;

const HALF: i32 = SUBPIXELS / 2;

/// A projected corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Subpixels.
    pub x: i32,
    /// Subpixels.
    pub y: i32,
    pub inverse_depth: f32,
    /// u, v and `n . l`.
    pub varyings: [f32; 3],
}

/// An edge function: not negative on the pixels to the inside.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// At the centre of the box's first pixel.
    value: i64,
    per_column: i64,
    per_row: i64,
}

/// The integer shape of a triangle on the canvas.
#[derive(Debug)]
pub(super) struct Outline {
    pub left: i32,
    pub top: i32,
    pub right: i32,
    pub bottom: i32,
    edges: [Edge; 3],
    /// Twice the area, square subpixels, positive.
    area: i64,
}

/// Greatest extent of a triangle whose edge functions fit into 32 bits, subpixels.
const SMALL: i64 = 1 << 13;

/// The edge functions of a triangle no larger than [`SMALL`]: at the first pixel, and their changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmallEdges {
    value: [i32; 3],
    per_column: [i32; 3],
    per_row: [i32; 3],
}

impl SmallEdges {
    /// All bits where a pixel, counted from the first of the outline's box, is covered; else none.
    #[inline(always)]
    pub fn inside(&self, row: i32, column: i32) -> i32 {
        let edge = |i: usize| self.value[i] + self.per_row[i] * row + self.per_column[i] * column;
        !((edge(0) | edge(1) | edge(2)) >> 31)
    }
}

impl Outline {
    /// The outline of a counter-clockwise triangle (corners in subpixels), or `None` if it faces away or covers no pixel's
    /// centre inside the canvas.
    #[inline(always)]
    pub fn new(corners: [[i32; 2]; 3], width: i32, height: i32) -> Option<Self> {
        let [a, b, c] = corners;
        let area =
            i64::from(b[1] - a[1]) * i64::from(c[0] - a[0]) - i64::from(b[0] - a[0]) * i64::from(c[1] - a[1]);
        if area <= 0 {
            return None;
        }
        let bound = |axis: usize, limit: i32| {
            let low = a[axis].min(b[axis]).min(c[axis]);
            let high = a[axis].max(b[axis]).max(c[axis]);
            (((low + HALF - 1) >> 8).max(0), ((high + HALF) >> 8).min(limit))
        };
        let (left, right) = bound(0, width);
        let (top, bottom) = bound(1, height);
        if left >= right || top >= bottom {
            return None;
        }
        let first = [left * SUBPIXELS + HALF, top * SUBPIXELS + HALF];
        let edges = [Edge::new(a, c, first), Edge::new(c, b, first), Edge::new(b, a, first)];
        Some(Self { left, top, right, bottom, edges, area })
    }

    /// The edges, if they are short.
    #[inline(always)]
    pub fn small(&self) -> Option<SmallEdges> {
        let longest = SMALL * i64::from(SUBPIXELS);
        let short = |edge: &Edge| edge.per_column.abs() <= longest && edge.per_row.abs() <= longest;
        self.edges.iter().all(short).then(|| SmallEdges {
            value: self.edges.map(|edge| edge.value as i32),
            per_column: self.edges.map(|edge| edge.per_column as i32),
            per_row: self.edges.map(|edge| edge.per_row as i32),
        })
    }

    /// The covered columns of a row, both counted from the first of the box.
    #[inline(always)]
    pub fn span(&self, row: i32) -> Range<i32> {
        let mut columns = 0..self.right - self.left;
        for edge in &self.edges {
            edge.narrow(row, &mut columns);
        }
        columns
    }
}

impl Edge {
    /// The edge from `a` to `b` of a triangle that runs clockwise on the image.
    #[inline(always)]
    fn new(a: [i32; 2], b: [i32; 2], first: [i32; 2]) -> Self {
        let (dx, dy) = (i64::from(b[0] - a[0]), i64::from(b[1] - a[1]));
        // A pixel whose centre lies on an edge belongs to the triangle to its right or, on a level edge, below.
        let top_left = dy < 0 || (dy == 0 && dx > 0);
        let value = dx * i64::from(first[1] - a[1]) - dy * i64::from(first[0] - a[0]) - i64::from(!top_left);
        Self { value, per_column: -dy * i64::from(SUBPIXELS), per_row: dx * i64::from(SUBPIXELS) }
    }

    /// Takes from the `columns` of a row those outside.
    ///
    /// The quotients are exact: all numbers are integers below 2^52, and of such the double division never rounds a
    /// fraction up to the next integer.
    #[inline(always)]
    fn narrow(&self, row: i32, columns: &mut Range<i32>) {
        let (value, step) = (self.value + self.per_row * i64::from(row), self.per_column);
        if value < 0 {
            if step <= 0 {
                columns.end = columns.start;
            } else {
                let first_inside = ((step - 1 - value) as f64 / step as f64) as i32;
                columns.start = columns.start.max(first_inside);
            }
        } else if step < 0 {
            let last_inside = (value as f64 / -step as f64) as i32;
            columns.end = columns.end.min(last_inside.saturating_add(1));
        }
    }
}

/// A quantity linear in the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// At the centre of the facet's first pixel.
    value: f32,
    pub per_column: f32,
    pub per_row: f32,
}

impl Plane {
    /// The quantity along a row, counted from the facet's first.
    #[inline(always)]
    pub fn row(&self, row: i32) -> PlaneRow {
        PlaneRow { value: self.value + self.per_row * row as f32, per_column: self.per_column }
    }
}

/// A quantity linear along a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneRow {
    /// At the facet's first column.
    pub value: f32,
    pub per_column: f32,
}

impl PlaneRow {
    /// At a column, counted from the facet's first.
    #[inline(always)]
    pub fn at(&self, column: i32) -> f32 {
        self.value + self.per_column * column as f32
    }
}

/// A drawn triangle, for shading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub left: i32,
    pub top: i32,
    /// Index of its placement in the scene.
    pub placement: u32,
    pub inverse_depth: Plane,
    /// u, v and `n . l`, each over depth.
    pub varyings: [Plane; 3],
}

impl Facet {
    #[inline(always)]
    pub fn new(outline: &Outline, corners: &[Corner; 3], placement: u32) -> Self {
        let [a, b, c] = corners;
        let pixels = 1.0 / f64::from(SUBPIXELS);
        let ab = [f64::from(b.x - a.x) * pixels, f64::from(b.y - a.y) * pixels];
        let ac = [f64::from(c.x - a.x) * pixels, f64::from(c.y - a.y) * pixels];
        let first = [
            f64::from(outline.left * SUBPIXELS + HALF - a.x) * pixels,
            f64::from(outline.top * SUBPIXELS + HALF - a.y) * pixels,
        ];
        let inverse_determinant = -f64::from(SUBPIXELS * SUBPIXELS) / outline.area as f64;
        let [qa, qb, qc] = corners.each_ref().map(Corner::quantities);
        let planes: [Plane; 4] = std::array::from_fn(|i| {
            let (qa, qab, qac) = (qa[i], qb[i] - qa[i], qc[i] - qa[i]);
            let per_column = (qab * ac[1] - qac * ab[1]) * inverse_determinant;
            let per_row = (qac * ab[0] - qab * ac[0]) * inverse_determinant;
            let value = qa + (per_column * first[0] + per_row * first[1]);
            Plane { value: value as f32, per_column: per_column as f32, per_row: per_row as f32 }
        });
        let [inverse_depth, u, v, incidence] = planes;
        Self { left: outline.left, top: outline.top, placement, inverse_depth, varyings: [u, v, incidence] }
    }
}

impl Corner {
    /// 1, u, v and `n . l`, each over depth: what is linear in the image.
    #[inline(always)]
    fn quantities(&self) -> [f64; 4] {
        let [u, v, incidence] = self.varyings.map(|varying| varying * self.inverse_depth);
        [self.inverse_depth, u, v, incidence].map(f64::from)
    }
}
