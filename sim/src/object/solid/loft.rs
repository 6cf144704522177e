//! Surfaces through a row of closed rings.

use super::Solid;
use crate::object::paint::Region;
use nalgebra::Vector3;

/// A smooth surface through `rings` of equally many points, closed at both ends by flat caps.
///
/// Each ring turns right-handed about the direction in which the rings follow each other. The texture runs around
/// a ring from left to right and along the rings from bottom to top.
pub(crate) fn loft(rings: &[Vec<Vector3<f64>>], region: Region) -> Solid {
    let sides = rings[0].len();
    let last = rings.len() - 1;
    let mut solid = Solid::default();
    for (j, ring) in rings.iter().enumerate() {
        let (before, after) = (&rings[j.saturating_sub(1)], &rings[(j + 1).min(last)]);
        for k in 0..=sides {
            let around = ring[(k + 1) % sides] - ring[(k + sides - 1) % sides];
            let along = after[k % sides] - before[k % sides];
            let uv = region.uv(k as f64 / sides as f64, 1.0 - j as f64 / last as f64);
            solid.vertex(ring[k % sides], around.cross(&along).normalize(), uv);
        }
    }
    let row = sides as u32 + 1;
    for j in 0..last as u32 {
        for k in 0..sides as u32 {
            let a = j * row + k;
            solid.triangles.push([a, a + 1, a + row + 1]);
            solid.triangles.push([a, a + row + 1, a + row]);
        }
    }
    for (ring, inner, t) in [(&rings[0], &rings[1], 1.0), (&rings[last], &rings[last - 1], 0.0)] {
        let center = mean(ring);
        let normal = (center - mean(inner)).normalize();
        let uv = region.uv(0.5, t);
        let hub = solid.vertex(center, normal, uv);
        let rim: Vec<u32> = ring.iter().map(|&point| solid.vertex(point, normal, uv)).collect();
        for k in 0..sides {
            solid.facet([hub, rim[k], rim[(k + 1) % sides]]);
        }
    }
    solid
}

fn mean(ring: &[Vector3<f64>]) -> Vector3<f64> {
    ring.iter().sum::<Vector3<f64>>() / ring.len() as f64
}
