//! Prisms along y.

use super::Solid;
use crate::object::paint::Region;
use nalgebra::Vector3;

/// Extrudes a polygon of `[x, z]` corners, counter-clockwise seen from -y, over `y` in `[-half_width, half_width]`.
///
/// `hub` is a point from which all corners can be seen. `edges[i]` is the texture of the face over the edge from
/// corner `i` to the next, upright and unmirrored from outside; `left` and `right` those of the ends at +y and -y.
pub(crate) fn prism(
    corners: &[[f64; 2]],
    hub: [f64; 2],
    half_width: f64,
    edges: &[Region],
    left: Region,
    right: Region,
) -> Solid {
    let mut solid = Solid::default();
    for (i, &[x0, z0]) in corners.iter().enumerate() {
        let [x1, z1] = corners[(i + 1) % corners.len()];
        let normal = Vector3::new(z1 - z0, 0.0, x0 - x1).normalize();
        let upside_down = z1 < z0;
        let quad = [(x0, z0, 0.0, 1.0), (x0, z0, 1.0, 1.0), (x1, z1, 1.0, 0.0), (x1, z1, 0.0, 0.0)].map(
            |(x, z, s, t)| {
                let y = half_width * (2.0 * s - 1.0);
                let (s, t) = if upside_down { (1.0 - s, 1.0 - t) } else { (s, t) };
                solid.vertex(Vector3::new(x, y, z), normal, edges[i].uv(s, t))
            },
        );
        solid.facet([quad[0], quad[1], quad[2]]);
        solid.facet([quad[0], quad[2], quad[3]]);
    }

    let range = |axis: usize| {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        corners.iter().fold(start, |(low, high), corner| (low.min(corner[axis]), high.max(corner[axis])))
    };
    let ((x_low, x_high), (z_low, z_high)) = (range(0), range(1));
    for (side, region) in [(1.0, left), (-1.0, right)] {
        let normal = Vector3::new(0.0, side, 0.0);
        let mut point = |[x, z]: [f64; 2]| {
            let rightwards = if side > 0.0 { x_high - x } else { x - x_low };
            let uv = region.uv(rightwards / (x_high - x_low), (z_high - z) / (z_high - z_low));
            solid.vertex(Vector3::new(x, side * half_width, z), normal, uv)
        };
        let center = point(hub);
        let rim: Vec<u32> = corners.iter().map(|&corner| point(corner)).collect();
        for i in 0..rim.len() {
            solid.facet([center, rim[i], rim[(i + 1) % rim.len()]]);
        }
    }
    solid
}
