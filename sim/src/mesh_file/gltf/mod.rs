//! glTF 2.0 and GLB: the triangles of the default scene with their base colour.

mod document;
mod reader;

use super::files::Files;
use super::find::file_name;
use super::soup::Soup;
use super::{MAX_TRIANGLES, MAX_VERTICES, MeshFault, MeshFileError};
use gltf::mesh::Mode;
use gltf::{Document, Node, Primitive, Semantic};
use nalgebra::Matrix4;
use reader::Reader;
use std::path::Path;

/// Most nodes that are visited; a hierarchy with a loop has more.
const MAX_NODES: usize = 10_000;
/// Deepest hierarchy.
const MAX_DEPTH: usize = 100;
/// Most primitives, each of which has a material.
const MAX_PRIMITIVES: usize = 10_000;
/// What an index into a buffer or a view of it counts.
const BYTE: &str = "a byte of a buffer";

/// Reads a glTF or GLB file and all it names.
pub(crate) fn read(files: &mut Files<'_>, path: &Path) -> Result<Soup, MeshFileError> {
    let bytes = files.main()?;
    let (document, blob) = document::parse(&bytes, &file_name(path)).map_err(|fault| files.error(fault))?;
    let placed = primitives(&document).map_err(|fault| files.error(fault))?;
    let mut reader = Reader::new(files, blob);
    for (primitive, file_from_mesh) in &placed {
        reader.add(primitive, file_from_mesh)?;
    }
    Ok(reader.soup)
}

/// All primitives of triangles with `file_from_mesh`, within the budget.
fn primitives(document: &Document) -> Result<Vec<(Primitive<'_>, Matrix4<f64>)>, MeshFault> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots = scene.iter().flat_map(|scene| scene.nodes());
    let mut open: Vec<(Node<'_>, Matrix4<f64>, usize)> =
        roots.map(|node| (node, Matrix4::identity(), 0)).collect();
    open.reverse();
    let (mut found, mut visited, mut triangles, mut vertices) = (Vec::new(), 0, 0usize, 0usize);
    while let Some((node, file_from_parent, depth)) = open.pop() {
        visited += 1;
        within("nodes (or their hierarchy has a loop)", visited, MAX_NODES)?;
        within("levels of nodes (or their hierarchy has a loop)", depth, MAX_DEPTH)?;
        if node.skin().is_some() {
            return Err(MeshFault::Unsupported("a skin", "apply its pose and export it without"));
        }
        let weights = node.weights().or_else(|| node.mesh().and_then(|mesh| mesh.weights()));
        if weights.unwrap_or_default().iter().any(|&weight| weight != 0.0) {
            let remedy = "apply their weights and export it without";
            return Err(MeshFault::Unsupported("morph targets that change its shape", remedy));
        }
        let local = node.transform().matrix().map(|column| column.map(f64::from));
        let file_from_node = file_from_parent * Matrix4::from(local);
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
            if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                continue;
            }
            let positions = primitive.get(&Semantic::Positions).map_or(0, |accessor| accessor.count());
            let corners = primitive.indices().map_or(positions, |accessor| accessor.count());
            let more = if primitive.mode() == Mode::Triangles { corners / 3 } else { corners };
            triangles = triangles.saturating_add(more);
            vertices = vertices.saturating_add(positions);
            within("triangles", triangles, MAX_TRIANGLES)?;
            within("vertices", vertices, MAX_VERTICES)?;
            found.push((primitive, file_from_node));
            within("primitives", found.len(), MAX_PRIMITIVES)?;
        }
        let first = open.len();
        open.extend(node.children().map(|child| (child, file_from_node, depth + 1)));
        open[first..].reverse();
    }
    Ok(found)
}

fn within(what: &'static str, got: usize, limit: usize) -> Result<(), MeshFault> {
    if got > limit { Err(MeshFault::TooMany { what, got, limit }) } else { Ok(()) }
}
