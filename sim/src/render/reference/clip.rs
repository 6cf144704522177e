//! Clipping of the few triangles that cross the near plane or leave the guard band.

use super::super::NEAR;
use super::super::view::{GUARD, snap};
use super::raster::Corner;

/// A corner before projection.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClipCorner {
    /// `[column * depth, row * depth, depth]`.
    pub position: [f64; 3],
    /// u, v and `n . l`.
    pub varyings: [f64; 3],
}

/// The part of a triangle, projected, that lies behind the near plane and inside the guard band: a convex polygon, maybe empty.
/// Corners come with their varyings.
pub(super) fn clip(triangle: [ClipCorner; 3]) -> Vec<(Corner, [f32; 3])> {
    let insides: [fn(&[f64; 3]) -> f64; 5] = [
        |p| p[2] - NEAR,
        |p| p[0] + GUARD * p[2],
        |p| GUARD * p[2] - p[0],
        |p| p[1] + GUARD * p[2],
        |p| GUARD * p[2] - p[1],
    ];
    let mut polygon = triangle.to_vec();
    for inside in insides {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, corner) in polygon.iter().enumerate() {
            let next = &polygon[(index + 1) % polygon.len()];
            let (here, there) = (inside(&corner.position), inside(&next.position));
            if here >= 0.0 {
                kept.push(*corner);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(between(corner, next, here / (here - there)));
            }
        }
        polygon = kept;
    }
    polygon.iter().map(project).collect()
}

fn between(a: &ClipCorner, b: &ClipCorner, t: f64) -> ClipCorner {
    let mix = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + t * (b[i] - a[i]));
    ClipCorner { position: mix(a.position, b.position), varyings: mix(a.varyings, b.varyings) }
}

fn project(corner: &ClipCorner) -> (Corner, [f32; 3]) {
    let [x, y, z] = corner.position;
    let inverse = 1.0 / z;
    let projected = Corner { x: snap(x * inverse), y: snap(y * inverse), inverse_depth: inverse as f32 };
    (projected, corner.varyings.map(|varying| varying as f32))
}
