//! Object meshes as BOP keeps them: `models/obj_<id>.ply` in millimetres, its texture, and `models_info.json`.

use super::MILLIMETRES;
use crate::image_file::{CompressionType, Pixels, png};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::io;
use vantage_dataset::Symmetry;
use vantage_dataset::store::Fault;

/// A mesh in the object's own frame: z up, origin at the centre of its bounding box.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectModel {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors, one a vertex.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v down, one a vertex.
    pub uvs: Vec<[f32; 2]>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Albedo; none for a mesh without.
    pub texture: Option<Texture>,
    /// About z.
    pub symmetry: Symmetry,
    /// Licence of the mesh; none for one that the program itself made.
    pub licence: Option<String>,
}

/// An image that is laid on a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// sRGB and coverage, row-major from the top: `4 * width * height` bytes.
    pub rgba: Vec<u8>,
}

impl ObjectModel {
    /// Refuses what is no mesh.
    pub(super) fn check(&self, name: &str) -> Result<(), Fault> {
        let n = self.positions.len();
        let require = |holds: bool, field: &str, got: String, expected: String| {
            if holds { Ok(()) } else { Err(Fault::new(name, None, field, got, expected)) }
        };
        require(n > 0 && !self.triangles.is_empty(), "triangles", "none".to_owned(), "some".to_owned())?;
        for (field, length) in [("normals", self.normals.len()), ("uvs", self.uvs.len())] {
            require(length == n, field, length.to_string(), format!("{n}, one a vertex"))?;
        }
        let corner = self.triangles.iter().flatten().find(|&&corner| corner as usize >= n);
        let shown = corner.map_or(String::new(), u32::to_string);
        require(corner.is_none(), "triangles", shown, format!("vertices below {n}"))?;
        let numbers = self.positions.iter().chain(&self.normals).flatten().chain(self.uvs.iter().flatten());
        let stray = numbers.into_iter().find(|number| !number.is_finite());
        let shown = stray.map_or(String::new(), f32::to_string);
        require(stray.is_none(), "vertices", shown, "finite numbers".to_owned())?;
        let Some(Texture { width, height, rgba }) = &self.texture else { return Ok(()) };
        let bytes = 4 * u64::from(*width) * u64::from(*height);
        let expected = format!("{bytes} bytes, more than none");
        require(bytes > 0 && rgba.len() as u64 == bytes, "texture", format!("{} bytes", rgba.len()), expected)
    }

    /// The PLY file, which names `texture` beside it.
    pub(super) fn ply(&self, texture: &str) -> String {
        let mut text = String::from("ply\nformat ascii 1.0\n");
        let textured = self.texture.is_some();
        let mut line = |line: std::fmt::Arguments<'_>| {
            let _ = writeln!(text, "{line}");
        };
        if textured {
            line(format_args!("comment TextureFile {texture}"));
        }
        line(format_args!("element vertex {}", self.positions.len()));
        let coordinates: &[&str] = if textured { &["texture_u", "texture_v"] } else { &[] };
        for property in ["x", "y", "z", "nx", "ny", "nz"].iter().chain(coordinates) {
            line(format_args!("property float {property}"));
        }
        line(format_args!("element face {}", self.triangles.len()));
        line(format_args!("property list uchar int vertex_indices\nend_header"));
        for ((p, n), uv) in self.positions.iter().zip(&self.normals).zip(&self.uvs) {
            let [x, y, z] = p.map(|metres| (f64::from(metres) * MILLIMETRES) as f32);
            let [nx, ny, nz] = n;
            if textured {
                line(format_args!("{x} {y} {z} {nx} {ny} {nz} {} {}", uv[0], 1.0 - uv[1]));
            } else {
                line(format_args!("{x} {y} {z} {nx} {ny} {nz}"));
            }
        }
        self.triangles.iter().for_each(|[a, b, c]| line(format_args!("3 {a} {b} {c}")));
        text
    }

    /// The texture's PNG.
    pub(super) fn texture_png(&self) -> io::Result<Option<Vec<u8>>> {
        let encode = |texture: &Texture| {
            png(&Pixels::Rgba(&texture.rgba), texture.width, texture.height, CompressionType::Default)
        };
        self.texture.as_ref().map(encode).transpose()
    }

    /// The entry of `models_info.json`, millimetres.
    pub(super) fn info(&self) -> Value {
        let points: Vec<Vector3<f64>> = self
            .positions
            .iter()
            .map(|p| Vector3::from(p.map(|metres| f64::from(metres) * MILLIMETRES)))
            .collect();
        let mut info = Map::from_iter([("diameter".to_owned(), json!(diameter(&points)))]);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let min = points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            let max = points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
            info.insert(format!("min_{name}"), json!(min));
            info.insert(format!("size_{name}"), json!(max - min));
        }
        match self.symmetry {
            Symmetry::None => {}
            Symmetry::Cyclic { order } => {
                let turns: Vec<_> = (1..order).map(|k| turn_about_z(k, order)).collect();
                info.insert("symmetries_discrete".to_owned(), json!(turns));
            }
            Symmetry::Revolution => {
                let axis = json!([{"axis": [0, 0, 1], "offset": [0, 0, 0]}]);
                info.insert("symmetries_continuous".to_owned(), axis);
            }
        }
        Value::Object(info)
    }
}

/// The `k`-th turn of a symmetry, 4 x 4, row-major.
fn turn_about_z(k: u8, order: u8) -> [f64; 16] {
    let angle = 2.0 * std::f64::consts::PI * f64::from(k) / f64::from(order);
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    [c, -s, 0.0, 0.0, s, c, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
}

/// The greatest distance of two points.
///
/// No two points are further apart than their distances from the middle together, so that the outermost pairs come
/// first and most of the others need no look.
fn diameter(points: &[Vector3<f64>]) -> f64 {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let mut by_radius: Vec<_> = points.iter().map(|p| ((p - middle).norm(), *p)).collect();
    by_radius.sort_by(|a, b| {
        b.0.total_cmp(&a.0)
            .then_with(|| a.1.as_slice().partial_cmp(b.1.as_slice()).unwrap_or(std::cmp::Ordering::Equal))
    });
    by_radius.dedup();
    let mut greatest: f64 = 0.0;
    for (i, (radius, p)) in by_radius.iter().enumerate() {
        if 2.0 * radius <= greatest {
            break;
        }
        for (other, q) in &by_radius[i + 1..] {
            if radius + other <= greatest {
                break;
            }
            greatest = greatest.max((p - q).norm());
        }
    }
    greatest
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    #[test]
    fn the_diameter_is_that_of_all_pairs() {
        let mut stream = Seed(3).stream("points", 0);
        for n in [1, 2, 3, 50, 200] {
            let flat = if n % 2 == 0 { 0.1 } else { 1.0 };
            let points: Vec<_> = (0..n)
                .map(|_| Vector3::new(stream.normal(), flat * stream.normal(), 3.0 + stream.unit()))
                .collect();
            let pairs = points.iter().flat_map(|p| points.iter().map(move |q| (p - q).norm()));
            assert_eq!(diameter(&points), pairs.fold(0.0, f64::max));
        }
    }

    #[test]
    fn turns_of_a_symmetry_go_round_once() {
        let quarter = turn_about_z(1, 4);
        assert!((quarter[1] + 1.0).abs() < 1e-15 && (quarter[4] - 1.0).abs() < 1e-15);
        assert!((turn_about_z(2, 4)[0] + 1.0).abs() < 1e-15);
    }
}
