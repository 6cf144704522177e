//! What has been drawn so far: the nearest triangle of each pixel.

use super::clip::{ClipCorner, clip};
use super::raster::{Corner, Facet, Outline};
use super::view::{Vertex, View, outside};
use crate::mesh::Mesh;

/// Number of no facet.
pub(super) const NO_FACET: u32 = u32::MAX;

/// Depth and facet of each pixel, row-major, and the facets.
#[derive(Debug, Default)]
pub(super) struct Canvas {
    pub width: i32,
    pub height: i32,
    /// 1 / depth, 0 where nothing was drawn.
    pub inverse_depth: Vec<f32>,
    /// Index into `facets`, or [`NO_FACET`].
    pub nearest: Vec<u32>,
    pub facets: Vec<Facet>,
    vertices: Vec<Vertex>,
}

impl Canvas {
    pub fn clear(&mut self, width: u32, height: u32) {
        let pixels = width as usize * height as usize;
        self.width = width as i32;
        self.height = height as i32;
        self.inverse_depth.clear();
        self.inverse_depth.resize(pixels, 0.0);
        self.nearest.clear();
        self.nearest.resize(pixels, NO_FACET);
        self.facets.clear();
    }

    /// Pixels on which something was drawn.
    pub fn covered(&self) -> u32 {
        self.nearest.iter().map(|&facet| u32::from(facet != NO_FACET)).sum()
    }

    pub fn draw(&mut self, view: &View, mesh: &Mesh, placement: u32) {
        self.vertices.clear();
        self.vertices.extend(mesh.positions.iter().map(|&position| view.vertex(position)));
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

    fn fill(&mut self, outline: &Outline, corners: &[Corner; 3], placement: u32) {
        let facet = Facet::new(outline, corners, placement);
        let number = self.facets.len() as u32;
        let mut seen = false;
        for span in outline.spans() {
            let start = span.row as usize * self.width as usize + span.columns.start as usize;
            let end = start + span.columns.len();
            let row = facet.inverse_depth.row(span.row - outline.top);
            let first = span.columns.start - outline.left;
            let depths = &mut self.inverse_depth[start..end];
            let numbers = &mut self.nearest[start..end];
            for (i, (depth, nearest)) in depths.iter_mut().zip(numbers).enumerate() {
                let inverse_depth = row.at(first + i as i32);
                let nearer = inverse_depth > *depth;
                *depth = if nearer { inverse_depth } else { *depth };
                *nearest = if nearer { number } else { *nearest };
                seen |= nearer;
            }
        }
        if seen {
            self.facets.push(facet);
        }
    }
}

fn varyings(view: &View, mesh: &Mesh, index: usize) -> [f32; 3] {
    let [u, v] = mesh.uvs[index];
    [u, v, view.incidence(mesh.normals[index])]
}
