//! Geometry from primitives, in `f64` until the mesh is finished.

mod cuboid;
mod ellipsoid;
mod lathe;
mod loft;
mod prism;
mod tube;

pub(crate) use cuboid::{Faces, cuboid};
pub(crate) use ellipsoid::ellipsoid;
pub(crate) use lathe::{Skin, turned};
pub(crate) use loft::loft;
pub(crate) use prism::prism;
pub(crate) use tube::{arc, tube};

use crate::mesh::Mesh;
use nalgebra::{Rotation3, Unit, Vector3};

/// A textured triangle surface under construction, metres; the fields are those of [`Mesh`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Solid {
    pub positions: Vec<Vector3<f64>>,
    pub normals: Vec<Vector3<f64>>,
    pub uvs: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Solid {
    /// Adds a vertex and returns its index.
    pub fn vertex(&mut self, position: Vector3<f64>, normal: Vector3<f64>, uv: [f64; 2]) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Adds a triangle, turned so that it faces along the mean of its corners' normals.
    pub fn facet(&mut self, [a, b, c]: [u32; 3]) {
        let [p, q, r] = [a, b, c].map(|i| self.positions[i as usize]);
        let outward: Vector3<f64> = [a, b, c].iter().map(|&i| self.normals[i as usize]).sum();
        let faces_out = (q - p).cross(&(r - p)).dot(&outward) > 0.0;
        self.triangles.push(if faces_out { [a, b, c] } else { [a, c, b] });
    }

    /// Adds everything of `other`.
    pub fn join(mut self, other: Solid) -> Self {
        let offset = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|i| i + offset)));
        self
    }

    /// Moved by `(x, y, z)` metres.
    pub fn moved(mut self, x: f64, y: f64, z: f64) -> Self {
        let offset = Vector3::new(x, y, z);
        self.positions.iter_mut().for_each(|p| *p += offset);
        self
    }

    /// Turned about `axis` through the origin, radians.
    pub fn turned(mut self, axis: Unit<Vector3<f64>>, angle: f64) -> Self {
        let rotation = Rotation3::from_axis_angle(&axis, angle);
        self.positions.iter_mut().for_each(|p| *p = rotation * *p);
        self.normals.iter_mut().for_each(|n| *n = rotation * *n);
        self
    }

    /// Turned about z by a quarter, exactly.
    pub fn quarter_turned(mut self) -> Self {
        let quarter = |v: &mut Vector3<f64>| *v = Vector3::new(-v.y, v.x, v.z);
        self.positions.iter_mut().for_each(quarter);
        self.normals.iter_mut().for_each(quarter);
        self
    }

    /// Its image in the plane of x and z.
    pub fn mirrored(mut self) -> Self {
        self.positions.iter_mut().chain(&mut self.normals).for_each(|v| v.y = -v.y);
        self.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        self
    }

    /// Stretched about the origin by positive factors.
    pub fn scaled(mut self, x: f64, y: f64, z: f64) -> Self {
        let factors = Vector3::new(x, y, z);
        self.positions.iter_mut().for_each(|p| p.component_mul_assign(&factors));
        self.normals.iter_mut().for_each(|n| *n = n.component_div(&factors).normalize());
        self
    }

    /// Bent by a small displacement field; normals are rebuilt from the bent triangles that share a vertex.
    pub fn bent(mut self, bend: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Self {
        self.positions.iter_mut().for_each(|p| *p = bend(*p));
        let mut sums = vec![Vector3::zeros(); self.positions.len()];
        for corners in &self.triangles {
            let [p, q, r] = corners.map(|i| self.positions[i as usize]);
            let area = (q - p).cross(&(r - p));
            corners.iter().for_each(|&i| sums[i as usize] += area);
        }
        // Vertices doubled at a seam of the texture have to keep one normal.
        let twins: Vec<Vector3<f64>> = (0..sums.len())
            .map(|i| {
                let twin = |j: &usize| {
                    (self.positions[*j] - self.positions[i]).norm_squared() < 1e-18
                        && self.normals[*j].dot(&self.normals[i]) > 0.7
                };
                (0..sums.len()).filter(twin).map(|j| sums[j]).sum()
            })
            .collect();
        for (normal, sum) in self.normals.iter_mut().zip(twins) {
            *normal = sum.try_normalize(1e-18).unwrap_or(*normal);
        }
        self
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let start = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        self.positions.iter().fold(start, |(low, high), p| (low.inf(p), high.sup(p)))
    }

    /// Enclosed volume, cubic metres; where parts overlap it counts twice.
    pub fn volume(&self) -> f64 {
        let six = self.triangles.iter().map(|corners| {
            let [p, q, r] = corners.map(|i| self.positions[i as usize]);
            p.dot(&q.cross(&r))
        });
        six.sum::<f64>() / 6.0
    }

    /// The finished mesh.
    pub fn to_mesh(&self) -> Mesh {
        let single = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        Mesh {
            positions: self.positions.iter().map(single).collect(),
            normals: self.normals.iter().map(single).collect(),
            uvs: self.uvs.iter().map(|uv| [uv[0] as f32, uv[1] as f32]).collect(),
            triangles: self.triangles.clone(),
        }
    }
}
