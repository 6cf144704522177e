//! Things of no kind: one to six parts of any shape, anyhow joined, anyhow painted.
//!
//! Nothing but the object itself tells where its front is.

use super::Draft;
use crate::object::hull::hull;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Region, Rgb};
use crate::object::solid::{Faces, Skin, Solid, cuboid, ellipsoid, prism, tube, turned};
use nalgebra::{Rotation3, Unit, Vector3};
use rapier3d::prelude::{SharedShape, Vector};
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Most parts.
const PARTS: usize = 6;
/// Bears this tilt without a foot, radians.
const FIRM: f64 = 0.25;
/// What each part is painted in: its sides, and its ends.
const SIDES: [Region; PARTS] = [
    Region::new(0, 0, 64, 30),
    Region::new(64, 0, 64, 30),
    Region::new(0, 42, 64, 30),
    Region::new(64, 42, 64, 30),
    Region::new(0, 84, 64, 30),
    Region::new(64, 84, 64, 30),
];
const ENDS: [Region; PARTS] = [
    Region::new(0, 30, 64, 12),
    Region::new(64, 30, 64, 12),
    Region::new(0, 72, 64, 12),
    Region::new(64, 72, 64, 12),
    Region::new(0, 114, 64, 12),
    Region::new(64, 114, 64, 12),
];

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let parts = 1 + shape.below(PARTS);
    let size = shape.uniform(0.045, 0.08);
    let mut canvas = Canvas::new([0.5; 3]);
    let mut solid = Solid::default();
    let mut palette = Palette::draw(look);
    for number in 0..parts {
        if look.chance(0.4) {
            palette = Palette::draw(look);
        }
        paint(&mut canvas, number, &palette, look);
        // The first is the largest; each other one reaches into what is there.
        let own = size * if number == 0 { 1.0 } else { shape.uniform(0.3, 0.9) };
        let part = part(own, number, shape);
        let part = if shape.chance(0.5) { part } else { part.mirrored() };
        let part = part.turned(direction(shape), shape.uniform(0.0, 2.0 * PI));
        let place = if number == 0 {
            Vector3::zeros()
        } else {
            solid.positions[shape.below(solid.positions.len())] * shape.uniform(0.6, 1.1)
        };
        solid = solid.join(part.moved(place.x, place.y, place.z));
    }
    let solid = standing(solid, ENDS[0]).turned(Vector3::z_axis(), shape.uniform(0.0, 2.0 * PI));
    Draft { solid, canvas, density: 400.0 }
}

/// Turned so that it stands as firmly as it can, on a foot where that is not firm.
fn standing(solid: Solid, foot: Region) -> Solid {
    let turned = |solid: &Solid, (axis, angle): (Unit<Vector3<f64>>, f64)| solid.clone().turned(axis, angle);
    let poses = rests(&solid).into_iter().map(|pose| turned(&solid, pose));
    let best = poses.map(|solid| (tilt(&solid), solid)).max_by(|a, b| a.0.total_cmp(&b.0));
    let (firm, solid) = best.unwrap_or((0.0, solid));
    if firm > FIRM {
        return solid;
    }
    let (low, high) = solid.bounds();
    let center = center_of_mass(&solid);
    let radius = 0.35 * (high.z - low.z);
    let plate = cuboid([radius, radius, 0.04 * (high.z - low.z)], 0.0, &Faces::all(foot));
    solid.join(plate.moved(center.x, center.y, low.z))
}

/// Turns that bring the faces of the convex hull down.
fn rests(solid: &Solid) -> Vec<(Unit<Vector3<f64>>, f64)> {
    let Some(hull) = hull_shape(solid) else { return Vec::new() };
    let faces = hull.as_convex_polyhedron().map(|hull| hull.faces().to_vec()).unwrap_or_default();
    let down = |normal: Vector3<f64>| match Rotation3::rotation_between(&normal, &-Vector3::z()) {
        Some(turn) => turn.axis_angle().unwrap_or((Vector3::x_axis(), 0.0)),
        None => (Vector3::x_axis(), PI),
    };
    faces
        .iter()
        .map(|face| down(Vector3::new(face.normal.x.into(), face.normal.y.into(), face.normal.z.into())))
        .collect()
}

/// The least tilt at which it falls over, of even density inside its hull, radians.
fn tilt(solid: &Solid) -> f64 {
    let (low, high) = solid.bounds();
    let center = center_of_mass(solid);
    let near = low.z + 5e-4 * (high - low).norm();
    let support: Vec<&Vector3<f64>> = solid.positions.iter().filter(|p| p.z < near).collect();
    let reach = |k: i32| {
        let azimuth = f64::from(k) * PI / 12.0;
        let (sin, cos) = (libm::sin(azimuth), libm::cos(azimuth));
        let along = |p: &Vector3<f64>| p.x * cos + p.y * sin;
        support.iter().map(|p| along(p)).fold(f64::NEG_INFINITY, f64::max) - along(&center)
    };
    libm::atan2((0..24).map(reach).fold(f64::INFINITY, f64::min), center.z - low.z)
}

fn center_of_mass(solid: &Solid) -> Vector3<f64> {
    let Some(hull) = hull_shape(solid) else { return Vector3::zeros() };
    let center = hull.mass_properties(1.0).local_com;
    Vector3::new(center.x.into(), center.y.into(), center.z.into())
}

fn hull_shape(solid: &Solid) -> Option<SharedShape> {
    let points: Vec<[f32; 3]> =
        solid.positions.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect();
    let points: Vec<Vector> = hull(&points).into_iter().map(Vector::from).collect();
    SharedShape::convex_hull(&points)
}

/// A part of about this half size, by its number's regions.
fn part(size: f64, number: usize, shape: &mut Stream) -> Solid {
    let (side, end) = (SIDES[number], ENDS[number]);
    let half = [0; 3].map(|_| size * shape.uniform(0.45, 1.0));
    match shape.below(5) {
        0 => {
            let bevel = half.iter().copied().fold(f64::INFINITY, f64::min) * shape.uniform(0.0, 0.3);
            cuboid(
                half,
                bevel,
                &Faces { front: side, back: end, left: side, right: end, top: end, bottom: side },
            )
        }
        1 => lathe(half, shape, side, end),
        2 => {
            let bumps = [0; 2].map(|_| (direction(shape), shape.uniform(-0.35, 0.35)));
            ellipsoid(half, 14, 9, side).bent(|p| {
                let out = |(axis, height): &(Unit<Vector3<f64>>, f64)| {
                    height * libm::exp(-8.0 * (1.0 - axis.dot(&p.normalize())))
                };
                p * (1.0 + bumps.iter().map(out).sum::<f64>())
            })
        }
        3 => ring(half, shape, side),
        _ => {
            let corners = 3 + shape.below(4);
            let start = shape.uniform(0.0, 2.0 * PI);
            let outline: Vec<[f64; 2]> = (0..corners)
                .map(|i| {
                    let angle = start + 2.0 * PI * (i as f64 + shape.uniform(-0.25, 0.25)) / corners as f64;
                    [half[0] * libm::cos(angle), half[1] * libm::sin(angle)]
                })
                .collect();
            let faces: Vec<Region> = (0..corners).map(|i| if i % 2 == 0 { side } else { end }).collect();
            prism(&outline, [0.0, 0.0], half[2], &faces, end, side)
        }
    }
}

/// A surface of revolution of a random outline.
fn lathe(half: [f64; 3], shape: &mut Stream, side: Region, end: Region) -> Solid {
    let rows = 3 + shape.below(3);
    let outline: Vec<[f64; 2]> = (0..rows)
        .map(|i| {
            let z = half[2] * (2.0 * i as f64 / (rows - 1) as f64 - 1.0);
            [half[0] * shape.uniform(0.3, 1.0), z]
        })
        .collect();
    let (low, high) = (outline[0], outline[rows - 1]);
    let flat = half[1] / half[0];
    turned(
        &[
            (&[[0.0, low[1]], low], Skin::Disc(end)),
            (&outline, Skin::Wrap(side)),
            (&[high, [0.0, high[1]]], Skin::Disc(end)),
        ],
        16,
    )
    .scaled(1.0, flat, 1.0)
}

/// An arc of a ring, or nearly all of it.
fn ring(half: [f64; 3], shape: &mut Stream, side: Region) -> Solid {
    let sweep = shape.uniform(0.6 * PI, 1.95 * PI);
    let path: Vec<Vector3<f64>> = (0..13)
        .map(|i| {
            let angle = sweep * f64::from(i) / 12.0;
            Vector3::new(half[0] * libm::cos(angle), 0.0, half[2] * libm::sin(angle))
        })
        .collect();
    let thick = half[0].min(half[2]) * shape.uniform(0.15, 0.4);
    let taper = shape.uniform(0.5, 1.0);
    let radius = |share: f64| [thick * (1.0 - (1.0 - taper) * share); 2];
    tube(&path, radius, Vector3::y(), 7, side)
}

/// A ground, and one to three marks.
fn paint(canvas: &mut Canvas, number: usize, palette: &Palette, look: &mut Stream) {
    let tones = [palette.body, palette.shade, palette.panel, palette.accent, palette.trim];
    let first = look.below(tones.len());
    let [base, tone] = [tones[first], tones[(first + 1 + look.below(tones.len() - 1)) % tones.len()]];
    let marks: Vec<(Emblem, [f64; 2], f64)> = (0..1 + look.below(3))
        .map(|_| {
            let center = [look.uniform(0.15, 0.85), look.uniform(0.25, 0.75)];
            (Emblem::draw(look), center, look.uniform(0.15, 0.4))
        })
        .collect();
    let ground = Ground::draw(look);
    let grain = look.uniform(0.2, 0.6);
    let far = |colour: &Rgb| -> f64 {
        let off = |ground: Rgb| (0..3).map(|i| f64::from((colour[i] - ground[i]).abs())).sum::<f64>();
        off(base).min(off(tone))
    };
    // What stands out from both tones: otherwise a turned part would look alike from all sides.
    let inks = [palette.ink, palette.panel, palette.accent, palette.body, [1.0; 3], [0.0; 3]];
    let ink = inks.into_iter().max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(palette.ink);
    canvas.paint(SIDES[number], [2.0, 1.0], |patch| {
        ground.cover(patch, [base, tone], grain, look);
        for (emblem, center, half) in marks {
            let area = patch.square(center, half);
            patch.emblem(area, emblem, ink);
        }
        if look.chance(0.3) {
            let top = look.uniform(0.0, 0.8);
            patch.rect(Area::band(top, top + look.uniform(0.1, 0.2)), palette.logo);
        }
    });
    canvas.paint(ENDS[number], [4.0, 1.0], |patch| {
        ground.cover(patch, [tone, base], 0.5, look);
    });
}

/// Any direction.
fn direction(shape: &mut Stream) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from_fn(|_, _| shape.normal()))
}
