//! From what a file says to a surface as this project has it: metres, z up, centred, facing outward.

use super::soup::Soup;
use super::{MeshFault, Units};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Extents that an object may have, metres.
const EXTENTS: [f64; 2] = [0.005, 5.0];
/// Triangles thinner than this share of their longest edge have no area.
const SLIVER: f64 = 1e-6;
/// Faces that meet at a smaller angle look like one curved surface where the file has no normals: cosine.
const CREASE: f64 = 0.7;
/// At a corner where more faces meet than this, all are taken for one surface.
const MAX_FAN: usize = 64;
/// Largest texture coordinate.
const MAX_UV: f32 = 1e4;

/// A triangle with all that its corners have.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    /// Metres.
    pub points: [Vector3<f64>; 3],
    /// Unit vectors.
    pub normals: [Vector3<f64>; 3],
    /// v down.
    pub uvs: [[f64; 2]; 3],
    /// Index among the materials.
    pub material: usize,
}

impl Facet {
    /// Twice the area, along the side it faces.
    pub fn area(&self) -> Vector3<f64> {
        (self.points[1] - self.points[0]).cross(&(self.points[2] - self.points[0]))
    }

    fn turn(&mut self) {
        self.points.swap(1, 2);
        self.normals.swap(1, 2);
        self.uvs.swap(1, 2);
    }

    fn is_sliver(&self) -> bool {
        let [a, b, c] = self.points;
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        self.area().norm() <= SLIVER * longest
    }
}

/// The triangles that have an area.
pub(crate) fn surface(soup: &Soup, units: Units) -> Result<Vec<Facet>, MeshFault> {
    let mut facets = facets(soup, units)?;
    let all = facets.len();
    if all == 0 {
        return Err(MeshFault::NoTriangle);
    }
    let size = |extent| MeshFault::Size { extent, metres_per_unit: units.metres_per_unit, range: EXTENTS };
    // A needle that reaches far off is a fault of the file, even if nobody would see it.
    let (low, high) = bounds(&facets);
    if (high - low).max() > EXTENTS[1] {
        return Err(size((high - low).max()));
    }
    facets.retain(|facet| !facet.is_sliver());
    if facets.is_empty() {
        return Err(MeshFault::NoArea(all));
    }
    let (low, high) = bounds(&facets);
    if (high - low).max() < EXTENTS[0] {
        return Err(size((high - low).max()));
    }
    let center = 0.5 * (low + high);
    facets.iter_mut().flat_map(|facet| &mut facet.points).for_each(|p| *p -= center);
    shade(&mut facets);
    let volume: f64 = facets.iter().map(|f| f.points[0].dot(&f.points[1].cross(&f.points[2]))).sum();
    if volume < 0.0 {
        for facet in &mut facets {
            facet.turn();
            facet.normals = facet.normals.map(|normal| -normal);
        }
    }
    close(&mut facets);
    Ok(facets)
}

fn facets(soup: &Soup, units: Units) -> Result<Vec<Facet>, MeshFault> {
    let mut facets = Vec::new();
    for part in &soup.parts {
        if !part.positions.iter().flatten().all(|x| x.is_finite()) {
            return Err(MeshFault::NotFinite("vertex"));
        }
        if !part.uvs.iter().flatten().flatten().all(|x| x.abs() <= MAX_UV) {
            return Err(MeshFault::NotFinite("texture coordinate"));
        }
        let point = |i: u32| units.up.to_z_up(part.positions[i as usize]) * units.metres_per_unit;
        // A normal that is none, as YCB's mug has some, is made anew from the triangles.
        let normal = |i: u32| {
            let given = part.normals.as_ref().map(|normals| units.up.to_z_up(normals[i as usize]));
            let unit = given.and_then(|n| n.try_normalize(1e-6));
            unit.filter(|n| n.iter().all(|x| x.is_finite())).unwrap_or_else(Vector3::zeros)
        };
        let uv = |i: u32| part.uvs.as_ref().map_or([0.0; 2], |uvs| uvs[i as usize].map(f64::from));
        facets.extend(part.triangles.iter().map(|corners| Facet {
            points: corners.map(point),
            normals: corners.map(normal),
            uvs: corners.map(uv),
            material: part.material,
        }));
    }
    Ok(facets)
}

/// Lowest and highest corner of the bounding box.
fn bounds(facets: &[Facet]) -> (Vector3<f64>, Vector3<f64>) {
    let start = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    facets.iter().flat_map(|facet| &facet.points).fold(start, |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Turns faces to the side of the normals that the file gives, and makes those that it does not give.
fn shade(facets: &mut [Facet]) {
    for facet in &mut *facets {
        let given: Vector3<f64> = facet.normals.iter().sum();
        if given.dot(&facet.area()) < 0.0 {
            facet.turn();
        }
    }
    if facets.iter().flat_map(|facet| &facet.normals).all(|normal| *normal != Vector3::zeros()) {
        return;
    }
    let areas: Vec<Vector3<f64>> = facets.iter().map(Facet::area).collect();
    let mut around: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
    for (i, facet) in facets.iter().enumerate() {
        facet.points.iter().for_each(|p| around.entry(key(p)).or_default().push(i));
    }
    for (facet, area) in facets.iter_mut().zip(&areas) {
        let own = area.normalize();
        for (point, normal) in facet.points.iter().zip(&mut facet.normals) {
            if *normal != Vector3::zeros() {
                continue;
            }
            let fan = &around[&key(point)];
            let smooth =
                |other: &Vector3<f64>| fan.len() > MAX_FAN || other.dot(&own) > CREASE * other.norm();
            let sum: Vector3<f64> = fan.iter().take(MAX_FAN).map(|&i| areas[i]).filter(smooth).sum();
            *normal = sum.try_normalize(0.0).unwrap_or(own);
        }
    }
}

/// Gives open surfaces, as of cloth, a back, so that they are seen from both sides.
fn close(facets: &mut Vec<Facet>) {
    let mut balance: HashMap<([u64; 3], [u64; 3]), i64> = HashMap::new();
    for facet in &*facets {
        let corners = facet.points.map(|p| key(&p));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            *balance.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    let open = balance.values().filter(|&&balance| balance != 0).count();
    if open * 50 > balance.len() {
        let backs: Vec<Facet> = facets
            .iter()
            .map(|facet| {
                let mut back = facet.clone();
                back.turn();
                back.normals = back.normals.map(|normal| -normal);
                back
            })
            .collect();
        facets.extend(backs);
    }
}

/// Equal for points at one place.
fn key(point: &Vector3<f64>) -> [u64; 3] {
    // Adding zero makes -0 and 0 one number.
    (*point).map(|x| (x + 0.0).to_bits()).into()
}
