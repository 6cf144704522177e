//! Wavefront OBJ with MTL.
//!
//! A texture replaces the colour `Kd`, as it does for the exporters that write both; a material without `Kd` is
//! white; `Kd` is an sRGB value. Faces without a material are white. Textures repeat.

use super::files::Files;
use super::find::file_name;
use super::image::decode;
use super::soup::{Material, Part, Soup, Wrap};
use super::{MAX_TRIANGLES, MAX_VERTICES, MeshFault, MeshFileError, color};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use tobj::{GPU_LOAD_OPTIONS, LoadError};

/// More characters than any index of a face has.
const MAX_INDEX_DIGITS: usize = 10;

/// Most bytes of a line that is neither a vertex nor a face nor a comment: names, which each of the parts repeats.
const MAX_LINE: usize = 4096;

/// Reads an OBJ file and all it names.
pub(crate) fn read(files: &mut Files<'_>, path: &Path) -> Result<Soup, MeshFileError> {
    let text = plain(&files.main()?);
    // Of a line through three points the parser makes a triangle.
    let is_line = |line: &str| line.split_whitespace().next() == Some("l");
    let text: String = text.split_inclusive('\n').filter(|line| !is_line(line)).collect();
    check(&text).map_err(|fault| files.error(fault))?;
    let failed = RefCell::new(None);
    let shared = RefCell::new(&mut *files);
    let loaded = tobj::load_obj_buf(&mut text.as_bytes(), &GPU_LOAD_OPTIONS, |name| {
        materials(&mut shared.borrow_mut(), &name.to_string_lossy()).map_err(|error| {
            failed.borrow_mut().get_or_insert(error);
            LoadError::OpenFileFailed
        })
    });
    if let Some(error) = failed.into_inner() {
        return Err(error);
    }
    let syntax = |error: LoadError| MeshFault::Syntax { name: file_name(path), reason: error.to_string() };
    let (models, materials) = loaded.map_err(|error| files.error(syntax(error)))?;
    let materials = materials.map_err(|error| files.error(syntax(error)))?;
    let mut soup = looks(files, &materials)?;
    for tobj::Model { mesh, .. } in models {
        let part = part(mesh, &mut soup).map_err(|fault| files.error(fault))?;
        soup.parts.push(part);
    }
    Ok(soup)
}

/// The text without a byte-order mark; what is no UTF-8, as names and comments of old exporters, becomes a mark of its own.
fn plain(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).into_owned()
}

/// Refuses what would take too much memory, and what the parser takes for something else.
///
/// Words end at any white space of Unicode, as they do for the parser.
fn check(text: &str) -> Result<(), MeshFault> {
    let (mut vertices, mut triangles) = (0, 0);
    for line in text.split('\n') {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v" | "vt" | "vn") => vertices += 1,
            Some("f") => {
                let corners = words.try_fold(0usize, |count, word| {
                    let sane = word.split('/').all(|index| index.len() <= MAX_INDEX_DIGITS);
                    sane.then_some(count + 1)
                });
                let corners = corners.ok_or(MeshFault::Syntax {
                    name: "f".to_owned(),
                    reason: "an index is too long".to_owned(),
                })?;
                triangles += corners.saturating_sub(2);
            }
            Some(word) if !word.starts_with('#') && line.len() > MAX_LINE => {
                return Err(MeshFault::TooMany {
                    what: "characters in a line",
                    got: line.len(),
                    limit: MAX_LINE,
                });
            }
            _ => (),
        }
    }
    for (what, got, limit) in [
        ("triangles", triangles, MAX_TRIANGLES),
        ("vertices, texture coordinates and normals", vertices, MAX_VERTICES),
    ] {
        if got > limit {
            return Err(MeshFault::TooMany { what, got, limit });
        }
    }
    Ok(())
}

/// Reads an MTL file.
fn materials(
    files: &mut Files<'_>,
    name: &str,
) -> Result<(Vec<tobj::Material>, std::collections::HashMap<String, usize>), MeshFileError> {
    let text = plain(&files.read(name)?);
    let syntax = |reason: String| MeshFault::Syntax { name: name.to_owned(), reason };
    for line in text.split('\n') {
        let mut words = line.split_whitespace();
        if let Some(key @ ("Ka" | "Kd" | "Ks" | "Ke")) = words.next()
            && words.count() < 3
        {
            return Err(files.error(syntax(format!("`{key}` needs three numbers"))));
        }
    }
    tobj::load_mtl_buf(&mut text.as_bytes()).map_err(|error| files.error(syntax(error.to_string())))
}

/// The materials with their images, and the white of faces without a material behind them.
fn looks(files: &mut Files<'_>, materials: &[tobj::Material]) -> Result<Soup, MeshFileError> {
    let mut soup = Soup::default();
    let mut known = BTreeMap::new();
    for material in materials {
        let mut look =
            Material { name: material.name.clone(), color: [1.0; 3], image: None, wrap: [Wrap::Repeat; 2] };
        match &material.diffuse_texture {
            Some(name) if name.starts_with('-') => {
                return Err(files.error(MeshFault::Unsupported(
                    "options before the file name in `map_Kd`",
                    "write the name alone",
                )));
            }
            Some(name) => {
                if !known.contains_key(name) {
                    let bytes = files.read(name)?;
                    let added = decode(files, &bytes, name).and_then(|image| soup.add_image(image));
                    known.insert(name.clone(), added.map_err(|fault| files.error(fault))?);
                }
                look.image = Some(known[name]);
            }
            None => {
                let encoded = material.diffuse.unwrap_or([1.0; 3]);
                if !encoded.iter().all(|channel| channel.is_finite()) {
                    return Err(files.error(MeshFault::NotFinite("colour `Kd`")));
                }
                look.color = encoded.map(|channel| color::linear(channel.clamp(0.0, 1.0)));
            }
        }
        soup.materials.push(look);
    }
    let white =
        Material { name: "without a name".to_owned(), color: [1.0; 3], image: None, wrap: [Wrap::Repeat; 2] };
    soup.materials.push(white);
    Ok(soup)
}

fn part(mesh: tobj::Mesh, soup: &mut Soup) -> Result<Part, MeshFault> {
    let white = soup.materials.len() - 1;
    if mesh.material_id.is_none() && white > 0 {
        let names: Vec<String> =
            soup.materials[..white].iter().map(|look| format!("`{}`", look.name)).collect();
        return Err(MeshFault::UnknownMaterial(names.join(", ")));
    }
    let material = mesh.material_id.unwrap_or(white);
    let textured = soup.materials[material].image.is_some();
    if !textured && !mesh.vertex_color.is_empty() {
        return Err(MeshFault::Unsupported("colours at its vertices", "bake them into a texture"));
    }
    let triples = |numbers: Vec<f32>| -> Vec<[f32; 3]> { numbers.as_chunks().0.to_vec() };
    let positions = triples(mesh.positions);
    let normals = triples(mesh.normals);
    let uvs: Vec<[f32; 2]> = mesh.texcoords.as_chunks().0.iter().map(|&[u, v]| [u, 1.0 - v]).collect();
    let whole = |len: usize| len == positions.len();
    if textured && !whole(uvs.len()) {
        return Err(MeshFault::NoTextureCoordinates(soup.materials[material].name.clone()));
    }
    Ok(Part {
        normals: whole(normals.len()).then_some(normals),
        uvs: whole(uvs.len()).then_some(uvs),
        triangles: mesh.indices.as_chunks().0.to_vec(),
        positions,
        material,
    })
}
