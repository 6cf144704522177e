//! Tubes along plane curves: handles, spouts, arms.

use super::{Solid, loft};
use crate::object::paint::Region;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Sweeps an ellipse along `path`, a curve in a plane with unit normal `plane`; `radii` are half widths
/// `[in the plane, across it]` at each point of the path.
pub(crate) fn tube(
    path: &[Vector3<f64>],
    radii: impl Fn(f64) -> [f64; 2],
    plane: Vector3<f64>,
    sides: usize,
    region: Region,
) -> Solid {
    let last = path.len() - 1;
    let rings: Vec<Vec<Vector3<f64>>> = path
        .iter()
        .enumerate()
        .map(|(j, center)| {
            let tangent = (path[(j + 1).min(last)] - path[j.saturating_sub(1)]).normalize();
            let inward = plane.cross(&tangent);
            let [inside, across] = radii(j as f64 / last as f64);
            (0..sides)
                .map(|k| {
                    let angle = 2.0 * PI * k as f64 / sides as f64;
                    center + inward * (inside * libm::cos(angle)) + plane * (across * libm::sin(angle))
                })
                .collect()
        })
        .collect();
    loft(&rings, region)
}

/// `points` points of an elliptic arc `center + cos(a) * x_axis + sin(a) * z_axis`, `a` from `from` to `to` radians.
pub(crate) fn arc(
    center: Vector3<f64>,
    x_axis: Vector3<f64>,
    z_axis: Vector3<f64>,
    [from, to]: [f64; 2],
    points: usize,
) -> Vec<Vector3<f64>> {
    (0..points)
        .map(|i| {
            let angle = from + (to - from) * i as f64 / (points - 1) as f64;
            center + x_axis * libm::cos(angle) + z_axis * libm::sin(angle)
        })
        .collect()
}
