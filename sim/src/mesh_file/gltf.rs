//! glTF 2.0 and GLB: the triangles of the default scene with their base colour.

use super::files::{Files, file_name};
use super::image::decode;
use super::soup::{Material, Part, Soup, Wrap};
use super::{MAX_TRIANGLES, MAX_VERTICES, MeshFault, MeshFileError};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::texture::WrappingMode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};
use nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use percent_encoding::percent_decode_str;
use std::collections::BTreeMap;
use std::path::Path;

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
/// Most nodes that are visited; a hierarchy with a loop has more.
const MAX_NODES: usize = 10_000;
/// What an index into a buffer or a view of it counts.
const BYTE: &str = "a byte of a buffer";
/// Deepest hierarchy.
const MAX_DEPTH: usize = 100;

/// Reads a glTF or GLB file and all it names.
pub(crate) fn read(files: &mut Files<'_>, path: &Path) -> Result<Soup, MeshFileError> {
    let bytes = files.main()?;
    let (document, blob) = parse(&bytes, &file_name(path)).map_err(|fault| files.error(fault))?;
    let placed = primitives(&document).map_err(|fault| files.error(fault))?;
    let mut reader =
        Reader { files, buffers: BTreeMap::new(), blob, images: BTreeMap::new(), soup: Soup::default() };
    for (primitive, file_from_mesh) in &placed {
        let part = reader.part(primitive, file_from_mesh)?;
        reader.soup.parts.extend(part);
    }
    Ok(reader.soup)
}

fn parse(bytes: &[u8], name: &str) -> Result<(Document, Option<Vec<u8>>), MeshFault> {
    let syntax = |reason: String| MeshFault::Syntax { name: name.to_owned(), reason };
    if let [b'g', b'l', b'T', b'F', _, _, _, _, length @ ..] = bytes {
        let length = length.first_chunk().map_or(0, |four| u32::from_le_bytes(*four));
        if length < 12 || length as usize > bytes.len() {
            return Err(syntax(format!("the header says {length} bytes, the file has {}", bytes.len())));
        }
    }
    let Gltf { document, blob } =
        Gltf::from_slice_without_validation(bytes).map_err(|error| syntax(error.to_string()))?;
    let used =
        |among: &[&str]| document.extensions_used().find(|name| among.contains(name)).map(str::to_owned);
    let (decisive, holding) = (used(&DECISIVE), used(&HOLDING));
    let required = document.extensions_required().next().map(str::to_owned);
    if let Some(extension) = required.or(decisive) {
        return Err(MeshFault::Extension(extension));
    }
    attributes_exist(&document)?;
    let document = Document::from_json(document.into_json())
        .map_err(|error| holding.map_or_else(|| syntax(error.to_string()), MeshFault::Extension))?;
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

struct Reader<'f, 's> {
    files: &'f mut Files<'s>,
    /// By index in the file.
    buffers: BTreeMap<usize, Vec<u8>>,
    blob: Option<Vec<u8>>,
    /// Index in the file to index in the soup.
    images: BTreeMap<usize, usize>,
    soup: Soup,
}

impl Reader<'_, '_> {
    /// A primitive in the frame of the file; `None` if it has no triangle.
    fn part(
        &mut self,
        primitive: &Primitive<'_>,
        file_from_mesh: &Matrix4<f64>,
    ) -> Result<Option<Part>, MeshFileError> {
        let material = self.material(primitive)?;
        let textured = self.soup.materials[material].image.is_some();
        let name = || self.soup.materials[material].name.clone();
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(None) };
        let set =
            primitive.material().pbr_metallic_roughness().base_color_texture().map_or(0, |t| t.tex_coord());
        let uvs = primitive.get(&Semantic::TexCoords(set));
        if textured && uvs.is_none() {
            return Err(self.files.error(MeshFault::NoTextureCoordinates(name())));
        }
        let count = positions.count();
        let positions: Vec<[f32; 3]> = self.floats(&positions, count)?;
        let normals = primitive.get(&Semantic::Normals).map(|a| self.floats::<3>(&a, count)).transpose()?;
        let uvs = uvs.filter(|_| textured).map(|a| self.floats::<2>(&a, count)).transpose()?;
        let corners = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, count)?,
            None => (0..count as u32).collect(),
        };
        if let Some(colors) = primitive.get(&Semantic::Colors(0)) {
            self.refuse_varied_colors(&colors, count)?;
        }
        let mut triangles = triangles(primitive.mode(), &corners);
        let linear: Matrix3<f64> = file_from_mesh.fixed_view::<3, 3>(0, 0).into();
        let mirrored = linear.determinant() < 0.0;
        if mirrored {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        // The cofactors turn normals as the inverse transpose does, and exist where the matrix is singular.
        let [x, y, z] = [0, 1, 2].map(|column| linear.column(column).into_owned());
        let side = if mirrored { -1.0 } else { 1.0 };
        let cofactors = Matrix3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)]) * side;
        let moved = |p: [f32; 3]| file_from_mesh.transform_point(&Point3::from(p.map(f64::from))).coords;
        let single = |v: Vector3<f64>| -> [f32; 3] { v.map(|x| x as f32).into() };
        let part = Part {
            positions: positions.into_iter().map(|p| single(moved(p))).collect(),
            normals: normals.map(|normals| {
                let turned = |n: [f32; 3]| (cofactors * Vector3::from(n.map(f64::from))).normalize();
                normals.into_iter().map(|n| single(turned(n))).collect()
            }),
            uvs,
            triangles,
            material,
        };
        Ok(Some(part))
    }

    /// Index of the look of a primitive.
    fn material(&mut self, primitive: &Primitive<'_>) -> Result<usize, MeshFileError> {
        let material = primitive.material();
        let base = material.pbr_metallic_roughness();
        let [r, g, b, _] = base.base_color_factor();
        let mut look = Material {
            name: material.name().unwrap_or("without a name").to_owned(),
            color: [r, g, b].map(|channel| channel.clamp(0.0, 1.0)),
            image: None,
            wrap: [Wrap::Repeat; 2],
        };
        if let Some(info) = base.base_color_texture() {
            let sampler = info.texture().sampler();
            look.wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
                WrappingMode::Repeat => Wrap::Repeat,
                WrappingMode::MirroredRepeat => Wrap::Mirror,
                WrappingMode::ClampToEdge => Wrap::Clamp,
            });
            look.image = Some(self.image(&info.texture().source())?);
        }
        let materials = &mut self.soup.materials;
        Ok(materials.iter().position(|known| *known == look).unwrap_or_else(|| {
            materials.push(look);
            materials.len() - 1
        }))
    }

    fn image(&mut self, image: &gltf::Image<'_>) -> Result<usize, MeshFileError> {
        if let Some(&known) = self.images.get(&image.index()) {
            return Ok(known);
        }
        let (bytes, name) = match image.source() {
            gltf::image::Source::Uri { uri, .. } => {
                let short = if uri.starts_with("data:") {
                    format!("number {}", image.index())
                } else {
                    uri.to_owned()
                };
                (self.uri(uri)?, short)
            }
            gltf::image::Source::View { view, .. } => {
                let range = view.offset()..view.offset().saturating_add(view.length());
                let buffer = self.buffer(&view.buffer())?;
                let fault = MeshFault::Index { what: BYTE, got: range.end as u64, len: buffer.len() };
                let bytes = buffer.get(range).map(<[u8]>::to_vec).ok_or(fault);
                (bytes.map_err(|fault| self.files.error(fault))?, format!("number {}", image.index()))
            }
        };
        let decoded = decode(&bytes, &name).and_then(|decoded| self.soup.add_image(decoded));
        let index = decoded.map_err(|fault| self.files.error(fault))?;
        self.images.insert(image.index(), index);
        Ok(index)
    }

    fn buffer(&mut self, buffer: &gltf::Buffer<'_>) -> Result<&[u8], MeshFileError> {
        let index = buffer.index();
        if !self.buffers.contains_key(&index) {
            let bytes = match buffer.source() {
                gltf::buffer::Source::Bin => self.blob.take().unwrap_or_default(),
                gltf::buffer::Source::Uri(uri) => self.uri(uri)?,
            };
            if bytes.len() < buffer.length() {
                let fault = MeshFault::Index { what: BYTE, got: buffer.length() as u64, len: bytes.len() };
                return Err(self.files.error(fault));
            }
            self.buffers.insert(index, bytes);
        }
        Ok(&self.buffers[&index])
    }

    /// The bytes of a data URI or of a file.
    fn uri(&mut self, uri: &str) -> Result<Vec<u8>, MeshFileError> {
        let Some(data) = uri.strip_prefix("data:") else {
            let name = percent_decode_str(uri).decode_utf8_lossy().into_owned();
            return self.files.read(&name);
        };
        let decoded = data.split_once(";base64,").and_then(|(_, text)| BASE64_STANDARD.decode(text).ok());
        decoded.ok_or_else(|| {
            let reason = "a data URI is not base64".to_owned();
            self.files.error(MeshFault::Syntax { name: "data:".to_owned(), reason })
        })
    }

    /// The elements of an accessor, packed; all bounds are checked.
    fn elements(&mut self, accessor: &Accessor<'_>) -> Result<Vec<u8>, MeshFileError> {
        let (size, count, offset) = (accessor.size(), accessor.count(), accessor.offset());
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(self.files.error(MeshFault::Unsupported("sparse accessors", "export it without")));
        };
        let stride = view.stride().unwrap_or(size).max(1);
        let end = count.saturating_sub(1).saturating_mul(stride).saturating_add(offset).saturating_add(size);
        let (start, length) = (view.offset(), view.length());
        let buffer = self.buffer(&view.buffer())?;
        let bytes = buffer.get(start..).unwrap_or_default();
        let bytes = &bytes[..length.min(bytes.len())];
        if end > bytes.len() {
            let fault = MeshFault::Index { what: BYTE, got: end as u64 - 1, len: bytes.len() };
            return Err(self.files.error(fault));
        }
        Ok((0..count).flat_map(|i| &bytes[offset + i * stride..][..size]).copied().collect())
    }

    /// Vectors of `N` numbers; integers are normalized ones.
    fn floats<const N: usize>(
        &mut self,
        accessor: &Accessor<'_>,
        count: usize,
    ) -> Result<Vec<[f32; N]>, MeshFileError> {
        if accessor.dimensions().multiplicity() != N || accessor.count() != count {
            let reason = "an attribute has another type or length than its kind or its neighbours".to_owned();
            return Err(self.files.error(MeshFault::Syntax { name: "accessors".to_owned(), reason }));
        }
        let (kind, width) = (accessor.data_type(), accessor.data_type().size());
        let number = |bytes: &[u8]| match (kind, bytes) {
            (DataType::U8, &[a]) => f32::from(a) / 255.0,
            (DataType::U16, &[a, b]) => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
            (DataType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => f32::NAN,
        };
        let numbers: Vec<f32> = self.elements(accessor)?.chunks_exact(width).map(number).collect();
        Ok(numbers.as_chunks().0.to_vec())
    }

    fn indices(&mut self, accessor: &Accessor<'_>, vertices: usize) -> Result<Vec<u32>, MeshFileError> {
        let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, &byte| index << 8 | u32::from(byte));
        let indices: Vec<u32> =
            self.elements(accessor)?.chunks_exact(accessor.data_type().size()).map(index).collect();
        match indices.iter().find(|&&i| i as usize >= vertices) {
            Some(&i) => {
                Err(self.files.error(MeshFault::Index { what: "a vertex", got: i.into(), len: vertices }))
            }
            None => Ok(indices),
        }
    }

    fn refuse_varied_colors(&mut self, accessor: &Accessor<'_>, count: usize) -> Result<(), MeshFileError> {
        let rgb: Vec<[f32; 3]> = match accessor.dimensions() {
            Dimensions::Vec4 => {
                self.floats::<4>(accessor, count)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
            }
            _ => self.floats(accessor, count)?,
        };
        if rgb.iter().flatten().all(|&channel| channel == 1.0) {
            return Ok(());
        }
        let fault = MeshFault::Unsupported("colours at its vertices", "bake them into a texture");
        Err(self.files.error(fault))
    }
}

fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, c)| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[1], c[0], c[2]] })
            .collect(),
        Mode::TriangleFan => {
            let pairs = corners.get(1..).unwrap_or_default().windows(2);
            pairs.map(|c| [corners[0], c[0], c[1]]).collect()
        }
        _ => corners.as_chunks().0.to_vec(),
    }
}
