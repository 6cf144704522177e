//! Boxes with bevelled edges.

use super::Solid;
use crate::object::paint::Region;
use nalgebra::Vector3;

/// The textures of a box, each upright and unmirrored from outside; the top as seen from above with the front (+x)
/// at the bottom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Faces {
    /// +x.
    pub front: Region,
    /// -x.
    pub back: Region,
    /// +y.
    pub left: Region,
    /// -y.
    pub right: Region,
    /// +z.
    pub top: Region,
    /// -z.
    pub bottom: Region,
}

impl Faces {
    /// One texture on all faces.
    pub fn all(region: Region) -> Self {
        Self::around(region, region)
    }

    /// One texture on the four sides, another on top and bottom.
    pub fn around(side: Region, top: Region) -> Self {
        Self { front: side, back: side, left: side, right: side, top, bottom: top }
    }

    fn of(&self, axis: usize, sign: f64) -> Region {
        match (axis, sign > 0.0) {
            (0, true) => self.front,
            (0, false) => self.back,
            (1, true) => self.left,
            (1, false) => self.right,
            (_, true) => self.top,
            (_, false) => self.bottom,
        }
    }
}

/// A box about the origin with half sizes `half` and edges cut off at `bevel` metres, shaded as if rounded.
pub(crate) fn cuboid(half: [f64; 3], bevel: f64, faces: &Faces) -> Solid {
    let mut solid = Solid::default();
    let corner = |axis: usize, signs: [f64; 3]| {
        let inset: [f64; 3] = std::array::from_fn(|i| if i == axis { half[i] } else { half[i] - bevel });
        let position = Vector3::from_fn(|i, _| signs[i] * inset[i]);
        let sign = signs[axis];
        let (rightwards, downwards) = match axis {
            0 => (sign * position.y / half[1], -position.z / half[2]),
            1 => (-sign * position.x / half[0], -position.z / half[2]),
            _ => (position.y / half[1], sign * position.x / half[0]),
        };
        let mut normal = Vector3::zeros();
        normal[axis] = sign;
        (position, normal, faces.of(axis, sign).uv(0.5 + 0.5 * rightwards, 0.5 + 0.5 * downwards))
    };
    let mut polygon = |corners: &[(Vector3<f64>, Vector3<f64>, [f64; 2])]| {
        let indices: Vec<u32> = corners.iter().map(|&(p, n, uv)| solid.vertex(p, n, uv)).collect();
        for i in 1..indices.len() - 1 {
            solid.facet([indices[0], indices[i], indices[i + 1]]);
        }
    };
    let with = |axis: usize, sign: f64, second: usize, other: f64, third: f64| {
        let mut signs = [third; 3];
        signs[axis] = sign;
        signs[second] = other;
        signs
    };
    for axis in 0..3 {
        let second = (axis + 1) % 3;
        for sign in [-1.0, 1.0] {
            polygon(
                &[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(a, b)| corner(axis, with(axis, sign, second, a, b))),
            );
            if bevel > 0.0 {
                for other in [-1.0, 1.0] {
                    let [low, high] = [-1.0, 1.0].map(|third| with(axis, sign, second, other, third));
                    let strip =
                        [corner(axis, low), corner(axis, high), corner(second, high), corner(second, low)];
                    let border = [strip[0].2, strip[1].2];
                    polygon(&[
                        strip[0],
                        strip[1],
                        (strip[2].0, strip[2].1, border[1]),
                        (strip[3].0, strip[3].1, border[0]),
                    ]);
                }
            }
        }
    }
    if bevel > 0.0 {
        for index in 0..8u8 {
            let signs = std::array::from_fn(|bit| if index >> bit & 1 == 0 { -1.0 } else { 1.0 });
            let border = corner(0, signs).2;
            polygon(&[0, 1, 2].map(|axis| {
                let (position, normal, _) = corner(axis, signs);
                (position, normal, border)
            }));
        }
    }
    solid
}
