//! The parts, looks and images of a glTF document.

use super::BYTE;
use crate::mesh_file::files::Files;
use crate::mesh_file::image::decode;
use crate::mesh_file::soup::{Material, Part, Soup, Wrap};
use crate::mesh_file::{MeshFault, MeshFileError};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::texture::WrappingMode;
use gltf::{Accessor, Primitive, Semantic};
use nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use percent_encoding::percent_decode_str;
use std::collections::BTreeMap;

/// Reads what primitives name, each thing once.
pub(super) struct Reader<'f, 's> {
    files: &'f mut Files<'s>,
    /// By index in the file.
    buffers: BTreeMap<usize, Vec<u8>>,
    blob: Option<Vec<u8>>,
    /// Index in the file to index in the soup.
    images: BTreeMap<usize, usize>,
    pub soup: Soup,
}

impl<'f, 's> Reader<'f, 's> {
    pub fn new(files: &'f mut Files<'s>, blob: Option<Vec<u8>>) -> Self {
        Self { files, buffers: BTreeMap::new(), blob, images: BTreeMap::new(), soup: Soup::default() }
    }

    /// Adds a primitive in the frame of the file, if it has a triangle.
    pub fn add(
        &mut self,
        primitive: &Primitive<'_>,
        file_from_mesh: &Matrix4<f64>,
    ) -> Result<(), MeshFileError> {
        let material = self.material(primitive)?;
        let textured = self.soup.materials[material].image.is_some();
        let name = || self.soup.materials[material].name.clone();
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        let set =
            primitive.material().pbr_metallic_roughness().base_color_texture().map_or(0, |t| t.tex_coord());
        let uvs = primitive.get(&Semantic::TexCoords(set));
        if textured && uvs.is_none() {
            return Err(self.files.error(MeshFault::NoTextureCoordinates(name())));
        }
        let count = positions.count();
        let positions: Vec<[f32; 3]> = self.floats(&positions, count)?;
        let normals = primitive.get(&Semantic::Normals).map(|a| self.floats::<3>(&a, count)).transpose()?;
        let uvs = uvs.filter(|_| textured).map(|a| self.numbers::<2>(&a, count)).transpose()?;
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
        self.soup.parts.push(Part {
            positions: positions.into_iter().map(|p| single(moved(p))).collect(),
            normals: normals.map(|normals| {
                let turned = |n: [f32; 3]| (cofactors * Vector3::from(n.map(f64::from))).normalize();
                normals.into_iter().map(|n| single(turned(n))).collect()
            }),
            uvs,
            triangles,
            material,
        });
        Ok(())
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
                let bytes = self.buffer(&view.buffer())?[view.offset()..][..view.length()].to_vec();
                (bytes, format!("number {}", image.index()))
            }
        };
        let decoded = decode(self.files, &bytes, &name).and_then(|decoded| self.soup.add_image(decoded));
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
        let bytes = &self.buffer(&view.buffer())?[view.offset()..][..view.length()];
        if end > bytes.len() {
            let fault = MeshFault::Index { what: BYTE, got: end as u64 - 1, len: bytes.len() };
            return Err(self.files.error(fault));
        }
        Ok((0..count).flat_map(|i| &bytes[offset + i * stride..][..size]).copied().collect())
    }

    /// Vectors of `N` floats.
    fn floats<const N: usize>(
        &mut self,
        accessor: &Accessor<'_>,
        count: usize,
    ) -> Result<Vec<[f32; N]>, MeshFileError> {
        if accessor.data_type() == DataType::F32 { self.numbers(accessor, count) } else { Err(self.misfit()) }
    }

    /// Vectors of `N` numbers; integers are shares of their greatest.
    fn numbers<const N: usize>(
        &mut self,
        accessor: &Accessor<'_>,
        count: usize,
    ) -> Result<Vec<[f32; N]>, MeshFileError> {
        let kind = accessor.data_type();
        if accessor.dimensions().multiplicity() != N || accessor.count() != count {
            return Err(self.misfit());
        }
        let number = |bytes: &[u8]| match (kind, bytes) {
            (DataType::U8, &[a]) => Some(f32::from(a) / 255.0),
            (DataType::U16, &[a, b]) => Some(f32::from(u16::from_le_bytes([a, b])) / 65535.0),
            (DataType::F32, &[a, b, c, d]) => Some(f32::from_le_bytes([a, b, c, d])),
            _ => None,
        };
        let numbers: Option<Vec<f32>> =
            self.elements(accessor)?.chunks_exact(kind.size()).map(number).collect();
        Ok(numbers.ok_or_else(|| self.misfit())?.as_chunks().0.to_vec())
    }

    fn misfit(&self) -> MeshFileError {
        let reason =
            "indices or an attribute have another type or length than their kind or their neighbours"
                .to_owned();
        self.files.error(MeshFault::Syntax { name: "accessors".to_owned(), reason })
    }

    /// Indices of corners: single whole numbers, so that there are no more of them than the accessor counts.
    fn indices(&mut self, accessor: &Accessor<'_>, vertices: usize) -> Result<Vec<u32>, MeshFileError> {
        let whole = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !whole {
            return Err(self.misfit());
        }
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
                self.numbers::<4>(accessor, count)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
            }
            _ => self.numbers(accessor, count)?,
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
