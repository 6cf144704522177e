//! Ellipsoids.

use super::{Skin, Solid, turned};
use crate::object::paint::Region;
use std::f64::consts::PI;

/// An ellipsoid about the origin with the given half axes, its texture wrapped about z.
pub(crate) fn ellipsoid(half: [f64; 3], segments: usize, rings: usize, region: Region) -> Solid {
    let outline: Vec<[f64; 2]> = (0..=rings)
        .map(|i| {
            let latitude = PI * (i as f64 / rings as f64 - 0.5);
            let inside = i > 0 && i < rings;
            [if inside { libm::cos(latitude) } else { 0.0 }, libm::sin(latitude)]
        })
        .collect();
    turned(&[(&outline, Skin::Wrap(region))], segments).scaled(half[0], half[1], half[2])
}
