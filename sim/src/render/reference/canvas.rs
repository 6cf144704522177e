//! What has been drawn so far: the nearest triangle of each pixel.

use super::clip::{ClipCorner, clip};
use super::raster::{Corner, Facet, Outline, SmallEdges};
use super::view::{Vertex, View, outside};
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
        for triangle in &mesh.triangles {
            let indices = triangle.map(|index| index as usize);
            let vertices = indices.map(|index| self.vertices[index]);
            let [a, b, c] = vertices.map(|vertex| vertex.outside);
            if a & b & c & !outside::GUARD != 0 {
                continue;
            }
            if (a | b | c) & (outside::NEAR | outside::GUARD) == 0 {
                let corners = vertices.map(|vertex| [vertex.x, vertex.y]);
                let Some(outline) = Outline::new(corners, self.width, self.height) else { continue };
                let corners = std::array::from_fn(|i| Corner {
                    x: vertices[i].x,
                    y: vertices[i].y,
                    inverse_depth: vertices[i].inverse_depth,
                    varyings: varyings(view, mesh, indices[i]),
                });
                self.fill(&outline, &corners, placement);
                continue;
            }
            let polygon = clip(indices.map(|index| ClipCorner {
                position: view.homogeneous(mesh.positions[index]),
                varyings: varyings(view, mesh, index).map(f64::from),
            }));
            for i in 2..polygon.len() {
                let corners = [polygon[0], polygon[i - 1], polygon[i]];
                let positions = corners.map(|corner| [corner.x, corner.y]);
                if let Some(outline) = Outline::new(positions, self.width, self.height) {
                    self.fill(&outline, &corners, placement);
                }
            }
        }
    }

    #[inline(always)]
    fn fill(&mut self, outline: &Outline, corners: &[Corner; 3], placement: u32) {
        let facet = Facet::new(outline, corners, placement);
        let number = self.facets.len() as u32;
        let seen = match outline.small() {
            Some(edges) => self.fill_small(outline, edges, &facet, number),
            None => self.fill_spans(outline, &facet, number),
        };
        if seen {
            self.facets.push(facet);
        }
    }

    /// Draws a stride of pixels at a time; whether any was nearest.
    #[inline(always)]
    fn fill_small(&mut self, outline: &Outline, edges: SmallEdges, facet: &Facet, number: u32) -> bool {
        let mut seen = false;
        for row in 0..outline.bottom - outline.top {
            let plane = facet.inverse_depth.row(row);
            let first = self.index(outline.top + row, outline.left);
            for left in (0..outline.right - outline.left).step_by(STRIDE) {
                let start = first + left as usize;
                let pixels = (
                    self.inverse_depth[start..].first_chunk_mut::<STRIDE>(),
                    self.nearest[start..].first_chunk_mut::<STRIDE>(),
                );
                let (Some(depths), Some(numbers)) = pixels else { break };
                // Masks of bits instead of conditions, of which the compiler would make jumps.
                let mut nearer = [0; STRIDE];
                let mut inverse_depth = [0; STRIDE];
                for i in 0..STRIDE {
                    let column = left + i as i32;
                    let candidate = plane.at(column);
                    let in_box = (column - (outline.right - outline.left)) >> 31;
                    let in_front = -i32::from(candidate > depths[i]);
                    nearer[i] = (edges.inside(row, column) & in_box & in_front) as u32;
                    inverse_depth[i] = candidate.to_bits();
                }
                for i in 0..STRIDE {
                    let kept = depths[i].to_bits() & !nearer[i];
                    depths[i] = f32::from_bits((inverse_depth[i] & nearer[i]) | kept);
                    numbers[i] = (number & nearer[i]) | (numbers[i] & !nearer[i]);
                }
                seen |= nearer != [0; STRIDE];
            }
        }
        seen
    }

    /// Draws row by row; whether any pixel was nearest.
    #[inline(always)]
    fn fill_spans(&mut self, outline: &Outline, facet: &Facet, number: u32) -> bool {
        let mut seen = false;
        for row in 0..outline.bottom - outline.top {
            let columns = outline.span(row);
            if columns.is_empty() {
                continue;
            }
            let start = self.index(outline.top + row, outline.left + columns.start);
            let plane = facet.inverse_depth.row(row);
            let depths = &mut self.inverse_depth[start..start + columns.len()];
            let numbers = &mut self.nearest[start..start + columns.len()];
            for ((column, depth), nearest) in columns.zip(depths).zip(numbers) {
                let inverse_depth = plane.at(column);
                let nearer = inverse_depth > *depth;
                *depth = if nearer { inverse_depth } else { *depth };
                *nearest = if nearer { number } else { *nearest };
                seen |= nearer;
            }
        }
        seen
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
