//! What has been drawn so far: the nearest triangle of each pixel.

use super::super::candidates::Candidates;
use super::super::view::{Vertex, View, outside};
use super::clip::{ClipCorner, clip};
use super::raster::{Corner, Facet, Outline, Plane, PlaneRow, Slopes, SmallEdges};
use crate::mesh::Mesh;

/// Number of no facet.
pub(super) const NO_FACET: u32 = u32::MAX;

/// Pixels of a row that a small facet is drawn to at once; buffers have as much room beyond their end.
const STRIDE: usize = 8;

/// Depth and facet of each pixel, row-major, and the facets.
#[derive(Debug, Default)]
pub(super) struct Canvas {
    pub width: i32,
    pub height: i32,
    inverse_depth: Vec<f32>,
    nearest: Vec<u32>,
    pub facets: Vec<Facet>,
    vertices: Vec<Vertex>,
    candidates: Candidates,
}

impl Canvas {
    pub fn clear(&mut self, width: u32, height: u32) {
        let pixels = width as usize * height as usize + STRIDE;
        self.width = width as i32;
        self.height = height as i32;
        self.inverse_depth.clear();
        self.inverse_depth.resize(pixels, 0.0);
        self.nearest.clear();
        self.nearest.resize(pixels, NO_FACET);
        self.facets.clear();
    }

    /// 1 / depth of each pixel, 0 where nothing was drawn.
    pub fn inverse_depth(&self) -> &[f32] {
        &self.inverse_depth[..self.inverse_depth.len() - STRIDE]
    }

    /// Of each pixel, an index into the facets, or [`NO_FACET`].
    pub fn nearest(&self) -> &[u32] {
        &self.nearest[..self.nearest.len() - STRIDE]
    }

    /// Pixels on which something was drawn.
    pub fn covered(&self) -> u32 {
        self.nearest().iter().map(|&facet| u32::from(facet != NO_FACET)).sum()
    }

    #[inline(always)]
    pub fn draw(&mut self, view: &View, mesh: &Mesh, placement: u32) {
        view.project(&mesh.positions, &mut self.vertices);
        let mut candidates = std::mem::take(&mut self.candidates);
        let size = [self.width, self.height];
        for &number in candidates.find(&mesh.triangles, &self.vertices, size, 0) {
            let indices = mesh.triangles[number as usize].map(|index| index as usize);
            let vertices = indices.map(|index| self.vertices[index]);
            let [a, b, c] = vertices.map(|vertex| vertex.outside);
            if (a | b | c) & outside::UNPROJECTED == 0 {
                let corners = vertices.map(|vertex| [vertex.x, vertex.y]);
                let Some(outline) = Outline::new(corners, self.width, self.height) else { continue };
                let corners =
                    vertices.map(|Vertex { x, y, inverse_depth, .. }| Corner { x, y, inverse_depth });
                self.fill(
                    &outline,
                    &corners,
                    placement,
                    #[inline(always)]
                    || indices.map(|index| varyings(view, mesh, index)),
                );
                continue;
            }
            let polygon = clip(indices.map(|index| ClipCorner {
                position: view.homogeneous(mesh.positions[index]),
                varyings: varyings(view, mesh, index).map(f64::from),
            }));
            for i in 2..polygon.len() {
                let triangle = [polygon[0], polygon[i - 1], polygon[i]];
                let corners = triangle.map(|(corner, _)| corner);
                let positions = corners.map(|corner| [corner.x, corner.y]);
                if let Some(outline) = Outline::new(positions, self.width, self.height) {
                    self.fill(
                        &outline,
                        &corners,
                        placement,
                        #[inline(always)]
                        || triangle.map(|(_, varyings)| varyings),
                    );
                }
            }
        }
        self.candidates = candidates;
    }

    #[inline(always)]
    fn fill(
        &mut self,
        outline: &Outline,
        corners: &[Corner; 3],
        placement: u32,
        varyings: impl FnOnce() -> [[f32; 3]; 3],
    ) {
        let slopes = Slopes::new(outline, corners);
        let inverse_depth = slopes.plane(corners.each_ref().map(|corner| f64::from(corner.inverse_depth)));
        let number = self.facets.len() as u32;
        let seen = match outline.small() {
            Some(edges) => self.fill_small(outline, edges, &inverse_depth, number),
            None => self.fill_spans(outline, &inverse_depth, number),
        };
        if seen {
            let varyings = slopes.planes(corners, varyings());
            self.facets.push(Facet {
                left: outline.left,
                top: outline.top,
                placement,
                inverse_depth,
                varyings,
            });
        }
    }

    /// Draws strides of pixels; whether any was nearest.
    #[inline(always)]
    fn fill_small(&mut self, outline: &Outline, edges: SmallEdges, plane: &Plane, number: u32) -> bool {
        let width = outline.right - outline.left;
        let mut seen = false;
        for left in (0..width).step_by(STRIDE) {
            let edges = edges.at::<STRIDE>(left);
            for row in 0..outline.bottom - outline.top {
                let start = self.index(outline.top + row, outline.left + left);
                let plane = plane.row(row);
                let mut inside = [0; STRIDE];
                for (i, inside) in inside.iter_mut().enumerate() {
                    *inside = edges.inside(row, i) & ((left + i as i32 - width) >> 31);
                }
                seen |= self.plot(start, inside, plane, left, number);
            }
        }
        seen
    }

    /// Draws row by row; whether any pixel was nearest.
    #[inline(always)]
    fn fill_spans(&mut self, outline: &Outline, plane: &Plane, number: u32) -> bool {
        let mut seen = false;
        let crossing = outline.crossing();
        for row in 0..outline.bottom - outline.top {
            let columns = outline.span(crossing, row);
            let plane = plane.row(row);
            for left in columns.clone().step_by(STRIDE) {
                let start = self.index(outline.top + row, outline.left + left);
                let mut inside = [0; STRIDE];
                for (i, inside) in inside.iter_mut().enumerate() {
                    *inside = (left + i as i32 - columns.end) >> 31;
                }
                seen |= self.plot(start, inside, plane, left, number);
            }
        }
        seen
    }

    /// Draws to a stride of pixels, those that are `inside` (all bits or none) and farther away; whether there was any.
    #[inline(always)]
    fn plot(
        &mut self,
        start: usize,
        inside: [i32; STRIDE],
        plane: PlaneRow,
        first: i32,
        number: u32,
    ) -> bool {
        let pixels = (
            self.inverse_depth[start..].first_chunk_mut::<STRIDE>(),
            self.nearest[start..].first_chunk_mut::<STRIDE>(),
        );
        let (Some(depths), Some(numbers)) = pixels else { return false };
        // Copies, and masks of bits instead of conditions: else the compiler does one pixel after the other.
        let (mut new_depths, mut new_numbers) = (*depths, *numbers);
        let mut nearer = [0; STRIDE];
        for i in 0..STRIDE {
            let candidate = plane.at(first + i as i32);
            nearer[i] = (inside[i] & -i32::from(candidate > new_depths[i])) as u32;
            let kept = new_depths[i].to_bits() & !nearer[i];
            new_depths[i] = f32::from_bits((candidate.to_bits() & nearer[i]) | kept);
        }
        for i in 0..STRIDE {
            new_numbers[i] = (number & nearer[i]) | (new_numbers[i] & !nearer[i]);
        }
        *depths = new_depths;
        *numbers = new_numbers;
        nearer != [0; STRIDE]
    }

    fn index(&self, row: i32, column: i32) -> usize {
        row as usize * self.width as usize + column as usize
    }
}

#[inline(always)]
fn varyings(view: &View, mesh: &Mesh, index: usize) -> [f32; 3] {
    let [u, v] = mesh.uvs[index];
    [u, v, view.incidence(mesh.normals[index])]
}
