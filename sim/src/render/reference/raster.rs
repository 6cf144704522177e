//! Which pixels a triangle covers, and what varies over it.

use super::super::view::{SUBPIXELS, pixels};
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
    /// Along a column of strides of pixels.
    #[inline(always)]
    pub fn at<const N: usize>(&self, left: i32) -> EdgeColumns<N> {
        let mut value = [[0; N]; 3];
        for ((values, value), per_column) in value.iter_mut().zip(self.value).zip(self.per_column) {
            for (i, at_column) in values.iter_mut().enumerate() {
                *at_column = value + per_column * (left + i as i32);
            }
        }
        EdgeColumns { value, per_row: self.per_row }
    }
}

/// The edge functions of [`SmallEdges`] at some columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeColumns<const N: usize> {
    value: [[i32; N]; 3],
    per_row: [i32; 3],
}

impl<const N: usize> EdgeColumns<N> {
    /// All bits where a pixel is covered, in a row counted from the first of the outline's box; else none.
    #[inline(always)]
    pub fn inside(&self, row: i32, i: usize) -> i32 {
        let edge = |edge: usize| self.value[edge][i] + self.per_row[edge] * row;
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
        let (left, right) = pixels([a[0], b[0], c[0]], width, 0);
        let (top, bottom) = pixels([a[1], b[1], c[1]], height, 0);
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

    /// The edges that cross the box: all others are far from its pixels.
    #[inline(always)]
    pub fn crossing(&self) -> [bool; 3] {
        let (right, bottom) = (i64::from(self.right - self.left - 1), i64::from(self.bottom - self.top - 1));
        self.edges.map(
            #[inline(always)]
            |edge| edge.value + (edge.per_column * right).min(0) + (edge.per_row * bottom).min(0) < 0,
        )
    }

    /// The covered columns of a row, both counted from the first of the box.
    #[inline(always)]
    pub fn span(&self, crossing: [bool; 3], row: i32) -> Range<i32> {
        let mut columns = 0..self.right - self.left;
        for (edge, crossing) in self.edges.iter().zip(crossing) {
            if crossing {
                edge.narrow(row, &mut columns);
            }
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

/// How what is linear over a triangle changes on the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    /// From the first corner, pixels.
    ab: [f64; 2],
    ac: [f64; 2],
    /// To the centre of the outline's first pixel.
    first: [f64; 2],
    inverse_determinant: f64,
}

impl Slopes {
    #[inline(always)]
    pub fn new(outline: &Outline, corners: &[Corner; 3]) -> Self {
        let [a, b, c] = corners;
        let pixels = 1.0 / f64::from(SUBPIXELS);
        Self {
            ab: [f64::from(b.x - a.x) * pixels, f64::from(b.y - a.y) * pixels],
            ac: [f64::from(c.x - a.x) * pixels, f64::from(c.y - a.y) * pixels],
            first: [
                f64::from(outline.left * SUBPIXELS + HALF - a.x) * pixels,
                f64::from(outline.top * SUBPIXELS + HALF - a.y) * pixels,
            ],
            inverse_determinant: -f64::from(SUBPIXELS * SUBPIXELS) / outline.area as f64,
        }
    }

    /// What has these values at the corners.
    #[inline(always)]
    pub fn plane(&self, [a, b, c]: [f64; 3]) -> Plane {
        let Self { ab, ac, first, inverse_determinant } = self;
        let (b, c) = (b - a, c - a);
        let per_column = (b * ac[1] - c * ab[1]) * inverse_determinant;
        let per_row = (c * ab[0] - b * ac[0]) * inverse_determinant;
        let value = a + (per_column * first[0] + per_row * first[1]);
        Plane { value: value as f32, per_column: per_column as f32, per_row: per_row as f32 }
    }

    /// Varyings over depth, given the varyings of each corner: what is linear in the image.
    #[inline(always)]
    pub fn planes(&self, corners: &[Corner; 3], varyings: [[f32; 3]; 3]) -> [Plane; 3] {
        let at = |corner: usize, i: usize| f64::from(varyings[corner][i] * corners[corner].inverse_depth);
        let plane = |i: usize| self.plane([at(0, i), at(1, i), at(2, i)]);
        [plane(0), plane(1), plane(2)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::candidates::Candidates;
    use super::super::super::view::Vertex;
    use super::*;
    use vantage_dataset::Seed;

    #[test]
    fn candidates_are_the_triangles_that_have_an_outline() {
        const SIZE: [i32; 2] = [48, 32];
        let mut random = Seed(5).stream("triangles", 0);
        // About the image, and of all sizes: some face away, lie beyond or fall between the pixels' centres.
        let vertices: Vec<Vertex> = (0..3 * 1000)
            .map(|i| {
                let size = [40, 400, 20_000][i / 3 % 3];
                let mut at = |side: i32| 128 * side - size / 2 + random.below(size as usize) as i32;
                Vertex { x: at(SIZE[0]), y: at(SIZE[1]), inverse_depth: 1.0, outside: 0 }
            })
            .collect();
        let triangles: Vec<[u32; 3]> = (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let outlined = |triangle: &[u32; 3]| {
            let corners = triangle.map(|index| [vertices[index as usize].x, vertices[index as usize].y]);
            Outline::new(corners, SIZE[0], SIZE[1]).is_some()
        };
        let expected: Vec<u32> = (0..1000).filter(|&i| outlined(&triangles[i as usize])).collect();
        assert!((200..800).contains(&expected.len()), "{} of 1000", expected.len());
        assert_eq!(Candidates::default().find(&triangles, &vertices, SIZE, 0), expected);
    }

    #[test]
    fn edges_that_do_not_cross_the_box_bound_no_row() {
        let mut random = Seed(6).stream("triangles", 0);
        let (mut outlines, mut spared) = (0, 0);
        for _ in 0..2000 {
            let mut at = || random.below(60_000) as i32 - 26_000;
            let corners = [[at(), at()], [at(), at()], [at(), at()]];
            let Some(outline) = Outline::new(corners, 32, 32) else { continue };
            let crossing = outline.crossing();
            outlines += 1;
            spared += crossing.iter().filter(|&&crossing| !crossing).count();
            for row in 0..outline.bottom - outline.top {
                let (got, expected) = (outline.span(crossing, row), outline.span([true; 3], row));
                assert!(
                    got == expected || got.is_empty() && expected.is_empty(),
                    "{got:?}, expected {expected:?}"
                );
            }
        }
        assert!(outlines > 300 && spared > outlines, "{spared} edges of {outlines} outlines");
    }
}
