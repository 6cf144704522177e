//! What a glTF file says, before any of its buffers is read.

use super::BYTE;
use crate::mesh_file::MeshFault;
use gltf::{Document, Gltf};

/// Extensions that change shape or look where they are used, required or not.
const DECISIVE: [&str; 2] = ["KHR_texture_transform", "KHR_materials_pbrSpecularGlossiness"];
/// Extensions that hold geometry or images which, where no copy is kept for others, are missing elsewhere.
const HOLDING: [&str; 6] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
];

/// The document, with the binary part of a GLB.
pub(super) fn parse(bytes: &[u8], name: &str) -> Result<(Document, Option<Vec<u8>>), MeshFault> {
    let syntax = |reason: String| MeshFault::Syntax { name: name.to_owned(), reason };
    if let [b'g', b'l', b'T', b'F', _, _, _, _, length @ ..] = bytes {
        let length = length.first_chunk().map_or(0, |four| u32::from_le_bytes(*four));
        if length as usize != bytes.len() {
            return Err(syntax(format!("the header says {length} bytes, the file has {}", bytes.len())));
        }
    }
    let Gltf { document, blob } =
        Gltf::from_slice_without_validation(bytes).map_err(|error| syntax(error.to_string()))?;
    let version = &document.as_json().asset.version;
    if version.split('.').next() != Some("2") {
        return Err(syntax(format!(
            "its `asset.version` is {version:?}, expected 2.0; export it as glTF 2.0"
        )));
    }
    let used =
        |among: &[&str]| document.extensions_used().find(|name| among.contains(name)).map(str::to_owned);
    let (decisive, holding) = (used(&DECISIVE), used(&HOLDING));
    let required = document.extensions_required().next().map(str::to_owned);
    if let Some(extension) = required.or(decisive) {
        return Err(MeshFault::Extension(extension));
    }
    attributes_exist(&document)?;
    let document = Document::from_json(document.into_json())
        .map_err(|error| holding.map_or_else(|| syntax(first(&error)), MeshFault::Extension))?;
    views_fit(&document)?;
    images_are_somewhere(&document).map_err(syntax)?;
    nodes_are_trees(&document).map_err(syntax)?;
    Ok((document, blob))
}

/// Refuses attributes without an accessor, on which the validation of the rest would panic.
fn attributes_exist(document: &Document) -> Result<(), MeshFault> {
    let root = document.as_json();
    let len = root.accessors.len();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut named = primitives.flat_map(|primitive| primitive.attributes.values().map(|index| index.value()));
    match named.find(|&index| index >= len) {
        Some(got) => Err(MeshFault::Index { what: "an accessor", got: got as u64, len }),
        None => Ok(()),
    }
}

/// The first of the reasons, of which a hostile file has millions.
fn first(error: &gltf::Error) -> String {
    match error {
        gltf::Error::Validation(reasons) => {
            reasons.iter().take(1).map(|(at, why)| format!("{at}: {why}")).collect()
        }
        other => other.to_string(),
    }
}

/// Refuses views that reach beyond their buffer.
fn views_fit(document: &Document) -> Result<(), MeshFault> {
    for view in document.views() {
        let (end, len) = (view.offset().saturating_add(view.length()), view.buffer().length());
        if end > len {
            return Err(MeshFault::Index { what: BYTE, got: end as u64 - 1, len });
        }
    }
    Ok(())
}

/// Refuses images that are nowhere, or in a buffer and of no stated type.
fn images_are_somewhere(document: &Document) -> Result<(), String> {
    let is_somewhere = |image: &gltf::json::Image| match image.buffer_view {
        Some(_) => image.mime_type.is_some(),
        None => image.uri.is_some(),
    };
    match document.as_json().images.iter().position(|image| !is_somewhere(image)) {
        Some(index) => Err(format!(
            "image {index} has neither a `uri` nor a `bufferView` with a `mimeType`, expected one of them"
        )),
        None => Ok(()),
    }
}

/// Refuses a node that hangs twice in a scene.
fn nodes_are_trees(document: &Document) -> Result<(), String> {
    let mut parents = vec![0; document.nodes().len()];
    let mut seen = |node: gltf::Node<'_>| {
        parents[node.index()] += 1;
        (parents[node.index()] > 1).then(|| node.index())
    };
    let twice = document.nodes().find_map(|node| node.children().find_map(&mut seen));
    twice
        .map_or(Ok(()), |node| Err(format!("node {node} has more than one parent, expected a tree of nodes")))
}
