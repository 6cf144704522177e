//! Models of objects: `models_info.json`, and what PLY files say of surfaces.

use super::super::MILLIMETRES;
use super::json;
use super::symmetry::{Continuous, symmetry};
use crate::import::{FETCH_AGAIN, ImportError, ImportReport, read_file};
use nalgebra::Vector3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use vantage_dataset::Symmetry;

pub(super) const INFO: &str = "models_info.json";
const LARGEST_INFO: u64 = 1 << 24;
const LARGEST_MESH: u64 = 1 << 28;
/// No object is larger, nor any vertex farther from its model's origin, millimetres.
const LARGEST: f64 = 1e6;

/// What is known of a model; metres.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadModel {
    /// The centre of its bounding box, in the model's frame.
    pub center: Vector3<f64>,
    /// Diameter of the sphere about that centre that holds it, or its own diameter where there is no mesh.
    pub size: f64,
    /// About its z axis.
    pub symmetry: Symmetry,
    /// Its surface, if that is known.
    pub mesh: Option<MeshGeometry>,
}

/// Triangles in the model's frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshGeometry {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

#[derive(Deserialize)]
struct InfoEntry {
    diameter: f64,
    min_x: f64,
    min_y: f64,
    min_z: f64,
    size_x: f64,
    size_y: f64,
    size_z: f64,
    #[serde(default)]
    symmetries_discrete: Vec<Vec<f64>>,
    #[serde(default)]
    symmetries_continuous: Vec<Continuous>,
}

/// The models of a folder. A mesh that cannot be read is told, and its model is one without.
pub(super) fn read_models(
    folder: &Path,
    report: &mut ImportReport,
) -> Result<BTreeMap<u32, ReadModel>, ImportError> {
    let path = folder.join(INFO);
    let entries: BTreeMap<u32, InfoEntry> =
        json::read(&path, LARGEST_INFO, "an entry of each obj_id, as BOP has them")?;
    let mut models = BTreeMap::new();
    for (id, entry) in entries {
        let numbers = [entry.diameter, entry.size_x, entry.size_y, entry.size_z];
        let is_sound = numbers.iter().all(|value| (0.0..=LARGEST).contains(value)) && entry.diameter > 0.0;
        let center = Vector3::new(
            entry.min_x + entry.size_x / 2.0,
            entry.min_y + entry.size_y / 2.0,
            entry.min_z + entry.size_z / 2.0,
        ) / MILLIMETRES;
        if !is_sound || !center.iter().all(|value| value.abs() <= LARGEST / MILLIMETRES) {
            let got = format!("diameter and sizes {numbers:?} about {:?}", center * MILLIMETRES);
            let expected = "positive numbers of millimetres, up to a kilometre";
            return Err(ImportError::invalid(&path, id.to_string(), got, expected, FETCH_AGAIN));
        }
        let symmetry = symmetry(&path, id, &entry.symmetries_discrete, &entry.symmetries_continuous)?;
        let file = folder.join(format!("obj_{id:06}.ply"));
        let mesh = match read_ply(&file) {
            Ok(mesh) => Some(mesh),
            Err(error) => {
                report.skip(file, error);
                None
            }
        };
        let size = mesh.as_ref().map_or(entry.diameter / MILLIMETRES, |mesh| mesh.diameter(&center));
        models.insert(id, ReadModel { center, size, symmetry, mesh });
    }
    Ok(models)
}

impl MeshGeometry {
    fn diameter(&self, center: &Vector3<f64>) -> f64 {
        let radius = self.positions.iter().map(|p| (Vector3::from(p.map(f64::from)) - center).norm());
        2.0 * radius.fold(0.0, f64::max)
    }
}

/// Reads positions and faces of a PLY file in millimetres, ASCII or binary; polygons become fans of triangles.
pub(super) fn read_ply(path: &Path) -> Result<MeshGeometry, ImportError> {
    let bytes = read_file(path, LARGEST_MESH)?;
    let damaged = |error: ParseError| {
        ImportError::invalid(path, "PLY", error, "a mesh of vertices and faces", FETCH_AGAIN)
    };
    let mut reader = Reader::new(Cursor::new(&bytes[..]));
    let (vertices, faces) = (Parser::<Vertex>::new(), Parser::<Face>::new());
    let header = vertices.read_header(&mut reader).map_err(damaged)?;
    let total: usize = header.elements.values().map(|element| element.count).fold(0, usize::saturating_add);
    if total > bytes.len() {
        let got = format!("{total} elements in {} bytes", bytes.len());
        return Err(ImportError::invalid(path, "header", got, "a byte for each at least", FETCH_AGAIN));
    }
    let mut mesh = MeshGeometry::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read =
                    vertices.read_payload_for_element(&mut reader, element, &header).map_err(damaged)?;
                mesh.positions =
                    read.iter().map(|v| v.0.map(|mm| (f64::from(mm) / MILLIMETRES) as f32)).collect();
            }
            _ => {
                let read = faces.read_payload_for_element(&mut reader, element, &header).map_err(damaged)?;
                let fans = read.iter().filter(|_| name == "face").flat_map(|Face(corners)| fan(corners));
                mesh.triangles.extend(fans);
            }
        }
    }
    let corners = mesh.triangles.iter().flatten();
    let stray = corners.clone().find(|&&corner| corner as usize >= mesh.positions.len());
    let is_near =
        mesh.positions.iter().flatten().all(|value| f64::from(*value).abs() <= LARGEST / MILLIMETRES);
    if mesh.triangles.is_empty() || stray.is_some() || !is_near {
        let got = format!("{} vertices, {} triangles", mesh.positions.len(), mesh.triangles.len());
        let expected = "triangles, whose corners are vertices of the file within a kilometre";
        return Err(ImportError::invalid(path, "faces", got, expected, FETCH_AGAIN));
    }
    Ok(mesh)
}

fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]])
}

struct Vertex([f32; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f32::NAN; 3])
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|name| *name == key) else {
            return PropertyAccessResult::Ignored;
        };
        match property.to_f32_lossy() {
            Some(value) => {
                self.0[axis] = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::Ignored,
        }
    }
}

struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        if !["vertex_indices", "vertex_index"].contains(&key) {
            return PropertyAccessResult::Ignored;
        }
        // A negative number is no vertex, and is refused as one that is too large.
        let signed =
            |corners: Vec<i64>| corners.into_iter().map(|c| u32::try_from(c).unwrap_or(u32::MAX)).collect();
        self.0 = match property {
            Property::ListUInt(corners) => corners,
            Property::ListInt(corners) => signed(corners.into_iter().map(i64::from).collect()),
            Property::ListUShort(corners) => corners.into_iter().map(u32::from).collect(),
            Property::ListShort(corners) => signed(corners.into_iter().map(i64::from).collect()),
            Property::ListUChar(corners) => corners.into_iter().map(u32::from).collect(),
            Property::ListChar(corners) => signed(corners.into_iter().map(i64::from).collect()),
            _ => return PropertyAccessResult::Ignored,
        };
        PropertyAccessResult::Set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_normals_of_a_mesh_are_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("obj_000001.ply");
        let of = |header: &str, rows: [&str; 3]| {
            let [a, b, c] = rows;
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{header}\
                 element face 1\nproperty list uchar int vertex_indices\nend_header\n{a}\n{b}\n{c}\n3 0 1 2\n"
            );
            std::fs::write(&path, text).unwrap();
            read_ply(&path).unwrap()
        };
        let bare = of("", ["0 0 0", "100 0 0", "0 100 0"]);
        let colours = "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n\
                       property uchar blue\nproperty uchar alpha\n";
        let rest = " 0 0 1 200 100 50 255";
        let coloured =
            of(colours, [&format!("0 0 0{rest}"), &format!("100 0 0{rest}"), &format!("0 100 0{rest}")]);
        assert_eq!(bare.positions, [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]);
        assert_eq!((coloured.positions, coloured.triangles), (bare.positions, bare.triangles));
    }
}
