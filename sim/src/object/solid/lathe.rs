//! Surfaces of revolution about z.

use super::Solid;
use crate::object::paint::Region;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// How a turned surface is laid on the texture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Skin {
    /// Azimuth -180 to 180 degrees from left to right (azimuth 0, the front, in the middle), height upwards.
    Wrap(Region),
    /// Seen from above: +y to the right, the front (+x) at the bottom.
    Disc(Region),
}

/// Turns an outline of `[radius, z]` points about z, smoothly shaded along it.
///
/// The outside lies to the right of the direction of travel: a solid runs from the centre of its bottom outwards,
/// up, and back to the axis.
fn lathe(outline: &[[f64; 2]], segments: usize, skin: Skin) -> Solid {
    let steps: Vec<[f64; 2]> =
        outline.windows(2).map(|pair| [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]]).collect();
    let length = |step: &[f64; 2]| (step[0] * step[0] + step[1] * step[1]).sqrt();
    let total: f64 = steps.iter().map(length).sum();
    let widest = outline.iter().fold(0.0, |widest: f64, point| widest.max(point[0]));
    let rises = outline[outline.len() - 1][1] >= outline[0][1];

    let mut solid = Solid::default();
    let mut travelled = 0.0;
    for (j, &[radius, z]) in outline.iter().enumerate() {
        let near = &steps[j.saturating_sub(1)..(j + 1).min(steps.len())];
        let [along_r, along_z] = near.iter().fold([0.0, 0.0], |sum, step| {
            let l = length(step).max(f64::MIN_POSITIVE);
            [sum[0] + step[0] / l, sum[1] + step[1] / l]
        });
        let flat = if radius > 0.0 { along_z } else { 0.0 };
        for k in 0..=segments {
            let azimuth = (2.0 * (k % segments) as f64 / segments as f64 - 1.0) * PI;
            let (sin, cos) = (libm::sin(azimuth), libm::cos(azimuth));
            let position = Vector3::new(radius * cos, radius * sin, z);
            let normal = Vector3::new(flat * cos, flat * sin, -along_r).normalize();
            let share = travelled / total;
            let uv = match skin {
                Skin::Wrap(region) => {
                    region.uv(k as f64 / segments as f64, if rises { 1.0 - share } else { share })
                }
                Skin::Disc(region) => {
                    region.uv(0.5 + 0.5 * position.y / widest, 0.5 + 0.5 * position.x / widest)
                }
            };
            solid.vertex(position, normal, uv);
        }
        travelled += steps.get(j).map_or(0.0, length);
    }
    let row = segments as u32 + 1;
    for j in 0..steps.len() {
        for k in 0..segments as u32 {
            let a = j as u32 * row + k;
            let (b, c, d) = (a + 1, a + row + 1, a + row);
            if outline[j][0] > 0.0 {
                solid.triangles.push([a, b, c]);
            }
            if outline[j + 1][0] > 0.0 {
                solid.triangles.push([a, c, d]);
            }
        }
    }
    solid
}

/// Outlines turned about z and joined, each with its own skin; edges between them are sharp.
pub(crate) fn turned(parts: &[(&[[f64; 2]], Skin)], segments: usize) -> Solid {
    parts.iter().fold(Solid::default(), |solid, (outline, skin)| solid.join(lathe(outline, segments, *skin)))
}
