//! A prepared mesh, and the file that holds one: all that is drawn of it, and what there is to know without drawing it.
//!
//! ```text
//! vantage mesh 1 HASH HASH   of the next line, and of what follows it: BLAKE3, hexadecimal
//! {"hash": ...}              the facts
//! of the mesh and of each level of detail: positions, normals, texture coordinates, triangles
//! the points of the convex hull
//! the texture's finest level as PNG
//! ```
//!
//! Numbers are those of memory, little-endian. What is read back is equal to what was written, bit for bit.

use super::first_bytes;
use super::shape::Shape;
use crate::mesh::Mesh;
use crate::mesh_file::find::Source;
use crate::mesh_file::{self, Loaded, MeshFault, MeshFileError, Units};
use crate::model::{Model, Simpler};
use crate::texture::{TEXTURE_SIDES, Texture};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageFormat};
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use vantage_dataset::InstanceId;
use vantage_dataset::store::{open_regular, read_regular, write_atomically};

/// What a file begins with; the number is that of this layout.
const MARK: &str = "vantage mesh 1 ";
/// Longest first two lines, bytes: a mesh names few files.
const LONGEST_HEAD: u64 = 16 << 20;
/// Largest file, bytes: twice what the largest mesh takes.
const LARGEST: u64 = 1 << 30;

/// What there is to know of a mesh without drawing it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Facts {
    /// Hash of the contents of all files that it was read from, hexadecimal.
    pub hash: String,
    /// The first 8 bytes of it.
    pub id: InstanceId,
    /// The files that the mesh file names, in the order in which they were read.
    pub names: Vec<String>,
    /// Half its extents along x, y, z, metres.
    pub half_extents: [f64; 3],
    size: f64,
    mass: f64,
    hull_points: usize,
    /// The mesh itself, then each level of detail.
    levels: Vec<Level>,
    texture_side: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Level {
    vertices: usize,
    triangles: usize,
    /// From the mesh itself, metres.
    deviation: f64,
}

impl Facts {
    /// Memory that the object takes, bytes.
    pub fn bytes(&self) -> u64 {
        let levels = self.levels.iter().map(|level| 32 * level.vertices + 12 * level.triangles);
        (levels.sum::<usize>() + 4 * self.texture_side.pow(2) * 4 / 3) as u64
    }

    /// What a file says, if it is what was written.
    pub fn read(path: &Path) -> Option<Self> {
        let file = open_regular(path).ok()?.take(LONGEST_HEAD);
        Self::split(&mut BufReader::new(file)).map(|(facts, _)| facts)
    }

    /// Reads the first two lines: the facts, and the hash of what follows.
    fn split(file: &mut impl BufRead) -> Option<(Self, String)> {
        let (mut mark, mut facts) = (String::new(), String::new());
        file.read_line(&mut mark).ok()?;
        file.read_line(&mut facts).ok()?;
        let (of_facts, of_body) = mark.strip_prefix(MARK)?.strip_suffix('\n')?.split_once(' ')?;
        let facts = facts.strip_suffix('\n')?;
        (of_facts == hash_of(facts.as_bytes())).then_some(())?;
        Some((serde_json::from_str(facts).ok()?, of_body.to_owned()))
    }
}

/// A mesh from a file, ready to be drawn and simulated.
pub(super) struct Prepared {
    pub facts: Facts,
    pub model: Model,
    pub shape: Shape,
}

impl Prepared {
    /// Reads a mesh with all it names, and makes its levels of detail.
    pub fn of(source: &Source, units: Units) -> Result<Self, MeshFileError> {
        let Loaded { model, hash, names } = mesh_file::load(source, units)?;
        let shape = Shape::of(&model).ok_or_else(|| source.error(MeshFault::NoVolume))?;
        let level = |(mesh, deviation): (&Mesh, f64)| Level {
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
            deviation,
        };
        let facts = Facts {
            hash: hash.to_hex().to_string(),
            id: first_bytes(&hash),
            names,
            half_extents: shape.half_extents.into(),
            size: shape.size,
            mass: shape.mass,
            hull_points: shape.hull.len(),
            levels: levels(&model).map(level).collect(),
            texture_side: model.texture.side(),
        };
        Ok(Self { facts, model, shape })
    }

    /// What a file holds, if it is what was written.
    pub fn read(path: &Path) -> Option<Self> {
        let file = read_regular(path, LARGEST).ok()?;
        let mut rest = file.as_slice();
        let (facts, hash) = Facts::split(&mut rest)?;
        (hash == hash_of(rest)).then_some(())?;
        let mut meshes =
            facts.levels.iter().map(|level| Some((take_mesh(&mut rest, level)?, level.deviation)));
        let (mesh, _) = meshes.next()??;
        let simpler = meshes.map(|level| level.map(|(mesh, deviation)| Simpler { mesh, deviation }));
        let simpler = simpler.collect::<Option<Vec<_>>>()?;
        let shape = Shape {
            size: facts.size,
            half_extents: facts.half_extents.into(),
            hull: take(&mut rest, facts.hull_points, f32::from_le_bytes)?,
            mass: facts.mass,
        };
        let image = image::load_from_memory_with_format(rest, ImageFormat::Png).ok()?.into_rgba8();
        let side = facts.texture_side;
        let fits = TEXTURE_SIDES.contains(&side) && side.is_power_of_two();
        (fits && image.dimensions() == (side as u32, side as u32)).then_some(())?;
        let texture = Texture::new(image.as_raw().as_chunks().0.to_vec());
        Some(Self { model: Model::with_levels(mesh, texture, simpler), shape, facts })
    }

    /// Writes the file whole or not at all.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let mut body = Vec::new();
        for (mesh, _) in levels(&self.model) {
            put(&mut body, &mesh.positions, f32::to_le_bytes);
            put(&mut body, &mesh.normals, f32::to_le_bytes);
            put(&mut body, &mesh.uvs, f32::to_le_bytes);
            put(&mut body, &mesh.triangles, u32::to_le_bytes);
        }
        put(&mut body, &self.shape.hull, f32::to_le_bytes);
        let texture = &self.model.texture;
        let side = texture.side() as u32;
        PngEncoder::new_with_quality(&mut body, CompressionType::Fast, FilterType::Adaptive)
            .write_image(texture.level(0).as_flattened(), side, side, ExtendedColorType::Rgba8)
            .map_err(io::Error::other)?;
        let facts = serde_json::to_string(&self.facts)?;
        let head = format!("{MARK}{} {}\n{facts}\n", hash_of(facts.as_bytes()), hash_of(&body));
        write_atomically(path, &[head.as_bytes(), &body].concat())
    }
}

/// The mesh itself and its levels of detail, with how far they deviate from it, metres.
fn levels(model: &Model) -> impl Iterator<Item = (&Mesh, f64)> {
    let simpler = model.own_levels().iter().map(|level| (&level.mesh, level.deviation));
    std::iter::once((&model.mesh, 0.0)).chain(simpler)
}

fn hash_of(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

fn put<T: Copy, const N: usize>(bytes: &mut Vec<u8>, rows: &[[T; N]], bits: fn(T) -> [u8; 4]) {
    bytes.extend(rows.as_flattened().iter().flat_map(|&number| bits(number)));
}

fn take<T, const N: usize>(bytes: &mut &[u8], rows: usize, number: fn([u8; 4]) -> T) -> Option<Vec<[T; N]>> {
    let taken = bytes.split_off(..rows.checked_mul(4 * N)?)?;
    let rows = taken.as_chunks::<4>().0.as_chunks::<N>().0;
    Some(rows.iter().map(|row| row.map(number)).collect())
}

fn take_mesh(bytes: &mut &[u8], level: &Level) -> Option<Mesh> {
    let mesh = Mesh {
        positions: take(bytes, level.vertices, f32::from_le_bytes)?,
        normals: take(bytes, level.vertices, f32::from_le_bytes)?,
        uvs: take(bytes, level.vertices, f32::from_le_bytes)?,
        triangles: take(bytes, level.triangles, u32::from_le_bytes)?,
    };
    let whole = mesh.triangles.as_flattened().iter().all(|&corner| (corner as usize) < level.vertices);
    whole.then_some(mesh)
}
