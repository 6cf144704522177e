//! The light of an episode or session.

use crate::render::Light;
use crate::scene::LightingSpec;
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Draws a light: any azimuth, everything else from the given ranges.
pub fn draw(spec: &LightingSpec, stream: &mut Stream) -> Light {
    let azimuth = stream.uniform(-PI, PI);
    let elevation = stream.uniform(spec.elevation_deg.low(), spec.elevation_deg.high()).to_radians();
    let horizontal = libm::cos(elevation);
    let direction =
        Vector3::new(horizontal * libm::cos(azimuth), horizontal * libm::sin(azimuth), libm::sin(elevation));
    let ambient = stream.uniform(spec.ambient.low(), spec.ambient.high());
    let diffuse = stream.uniform(spec.directional.low(), spec.directional.high());
    let mut tinted = |irradiance: f64| {
        std::array::from_fn(|_| (irradiance * (1.0 + stream.uniform(-spec.tint, spec.tint))) as f32)
    };
    Light { direction, ambient: tinted(ambient), diffuse: tinted(diffuse) }
}
