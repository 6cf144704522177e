//! Pots with spouts.

use super::{Draft, SPOTS, SQUARE, WRAP};
use crate::object::paint::{Area, Canvas, Emblem, Ground, Label, Palette, mix};
use crate::object::solid::{Skin, arc, ellipsoid, tube, turned};
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let radius = shape.uniform(0.045, 0.066);
    let height = radius * shape.uniform(1.2, 1.9);
    let foot = radius * shape.uniform(0.55, 0.75);
    let mouth = radius * shape.uniform(0.4, 0.6);

    let palette = Palette::draw(look);
    let ground = Ground::draw(look);
    let emblem = Emblem::draw(look);
    let grain = look.uniform(0.12, 0.3);
    let mut canvas = Canvas::new(palette.body);
    canvas.wrap(WRAP, [1.8 * PI * radius, height], |patch| {
        ground.cover(patch, [palette.body, mix(palette.body, palette.shade, 0.8)], grain, look);
        let turn = look.uniform(-8.0, 8.0);
        let left = Area::around([Label::share(90.0 + turn), 0.5], [look.uniform(34.0, 44.0) / 360.0, 0.36]);
        patch.disc(left, palette.panel);
        patch.emblem(left.part(0.15, 0.12, 0.85, 0.88), emblem, palette.logo);
        for azimuth in [-125.0, -102.0, -79.0, -56.0] {
            let half = look.uniform(5.0, 7.5) / 360.0;
            let s = Label::share(azimuth + turn);
            patch.rect(Area::new(s - half, 0.12, s + half, 0.88), palette.accent);
        }
    });
    canvas.paint(SQUARE, [1.0, 1.0], |patch| {
        patch.fill(palette.trim);
        patch.disc(Area::around([0.5, 0.84], [0.1, 0.1]), palette.panel);
    });
    canvas.plain(SPOTS[0], palette.trim);
    canvas.paint(SPOTS[1], [1.0, 2.0], |patch| {
        patch.fill(palette.body);
        patch.rect(Area::band(0.0, 0.3), palette.accent);
    });
    canvas.plain(SPOTS[2], palette.accent);
    canvas.plain(SPOTS[3], mix(palette.body, [0.0; 3], 0.3));

    let waist = libm::sin(0.12 * PI);
    let belly: Vec<[f64; 2]> = (0..=7)
        .map(|i| {
            let share = f64::from(i) / 7.0;
            let bulge = libm::sin(PI * (0.12 + 0.76 * share)) - waist;
            let ends = foot + (mouth - foot) * share;
            let r = ends + (radius - ends) * bulge / (1.0 - waist);
            [r, height * share]
        })
        .collect();
    let lid = height + shape.uniform(0.12, 0.3) * radius;
    let knob = radius * shape.uniform(0.12, 0.2);
    let pot = turned(
        &[
            (&[[0.0, 0.0], [foot, 0.0]], Skin::Disc(SPOTS[3])),
            (&belly, Skin::Wrap(WRAP)),
            (&[[mouth, height], [0.7 * mouth, 0.5 * (height + lid)], [0.0, lid]], Skin::Disc(SQUARE)),
        ],
        20,
    );
    let spout_end = Vector3::new(radius * shape.uniform(1.55, 1.8), 0.0, height * shape.uniform(0.85, 1.05));
    let spout_start = Vector3::new(0.75 * radius, 0.0, 0.35 * height);
    let knee = Vector3::new(1.4 * radius, 0.0, 0.35 * height);
    let path: Vec<Vector3<f64>> = (0..6)
        .map(|i| {
            let u = f64::from(i) / 5.0;
            spout_start * ((1.0 - u) * (1.0 - u)) + knee * (2.0 * u * (1.0 - u)) + spout_end * (u * u)
        })
        .collect();
    let [wide, narrow] = [0.28 * radius, radius * shape.uniform(0.1, 0.16)];
    let spout = tube(&path, |u| [wide + (narrow - wide) * u; 2], Vector3::y(), 8, SPOTS[1]);
    let grip = radius * shape.uniform(0.09, 0.13);
    let loop_path = arc(
        Vector3::new(-0.85 * radius, 0.0, 0.55 * height),
        Vector3::x() * (-radius * shape.uniform(0.55, 0.8)),
        Vector3::z() * (0.36 * height),
        [-0.5 * PI, 0.5 * PI],
        9,
    );
    let handle = tube(&loop_path, |_| [grip, 1.3 * grip], Vector3::y(), 7, SPOTS[0]);
    Draft {
        solid: pot.join(spout).join(handle).join(ellipsoid([knob; 3], 10, 6, SPOTS[2]).moved(
            0.0,
            0.0,
            lid + 0.6 * knob,
        )),
        canvas,
        density: 900.0,
    }
}
