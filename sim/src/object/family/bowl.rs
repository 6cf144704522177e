//! Bowls.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Label, Palette, Region, mix};
use crate::object::solid::{Faces, Skin, cuboid, turned};
use std::f64::consts::PI;
use vantage_dataset::Stream;

const OUTSIDE: Region = Region::new(0, 0, 128, 44);
const INSIDE: Region = Region::new(0, 44, 128, 44);
const FLOOR: Region = Region::new(0, 88, 40, 40);
const FOOT: Region = Region::new(40, 88, 44, 40);
const RIM: Region = Region::new(84, 88, 44, 40);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let radius = shape.uniform(0.06, 0.095);
    let height = radius * shape.uniform(0.65, 1.0);
    let foot = radius * shape.uniform(0.42, 0.6);
    let wall = radius * 0.07;

    let palette = Palette::draw(look);
    let (ground, lining) = (Ground::draw(look), Ground::draw(look));
    let emblem = Emblem::draw(look);
    let grain = look.uniform(0.15, 0.4);
    let turn = look.uniform(-8.0, 8.0);
    let at = |azimuth: f64, half_width: f64, top: f64, bottom: f64| {
        let s = Label::share(azimuth + turn);
        Area::new(s - half_width / 360.0, top, s + half_width / 360.0, bottom)
    };
    let size = [1.6 * PI * radius, height];
    let mut canvas = Canvas::new(palette.trim);
    canvas.wrap(OUTSIDE, size, |patch| {
        ground.cover(patch, [palette.body, palette.shade], grain, look);
        let front = at(0.0, look.uniform(38.0, 52.0), 0.16, 0.9);
        patch.disc(front, palette.panel);
        patch.emblem(front.part(0.1, 0.12, 0.9, 0.88), emblem, palette.logo);
        patch.rect(at(90.0, look.uniform(16.0, 24.0), 0.0, 1.0), palette.accent);
        for azimuth in [-110.0, -90.0, -70.0] {
            patch.disc(patch.square([Label::share(azimuth + turn), 0.5], 0.16), palette.panel);
        }
        patch.writing(at(180.0, 40.0, 0.35, 0.8), 2, palette.panel, look);
    });
    let glaze = mix(palette.body, [1.0; 3], look.uniform(0.25, 0.6));
    canvas.wrap(INSIDE, size, |patch| {
        lining.cover(patch, [glaze, mix(glaze, palette.body, 0.45)], grain, look);
        patch.rect(at(0.0, look.uniform(28.0, 40.0), 0.0, 1.0), palette.accent);
        patch.rect(at(0.0, 10.0, 0.0, 1.0), palette.panel);
        patch.rect(at(90.0, look.uniform(8.0, 14.0), 0.0, 1.0), palette.accent);
        for azimuth in [-110.0, -90.0, -70.0] {
            patch.disc(patch.square([Label::share(azimuth + turn), 0.4], 0.16), palette.body);
        }
    });
    canvas.paint(FLOOR, [1.0, 1.0], |patch| {
        patch.fill(glaze);
        patch.emblem(Area::new(0.15, 0.15, 0.85, 0.85), emblem, palette.accent);
    });
    canvas.plain(FOOT, palette.shade);

    let curve = |offset: f64| -> Vec<[f64; 2]> {
        (0..=5)
            .map(|i| {
                let angle = 0.5 * PI * f64::from(i) / 5.0;
                let [r, z] = [foot + (radius - foot) * libm::sin(angle), 1.0 - libm::cos(angle)];
                [r - offset, offset * (1.0 - z) + height * (0.06 + 0.94 * z)]
            })
            .collect()
    };
    let outside = curve(0.0);
    let mut inside = curve(wall);
    inside.reverse();
    let [floor_radius, floor] = inside[inside.len() - 1];
    let cup = turned(
        &[
            (&[[0.0, 0.0], [foot, 0.0]], Skin::Disc(FOOT)),
            (&[[foot, 0.0], [foot, 0.06 * height]], Skin::Wrap(FOOT)),
            (&outside, Skin::Wrap(OUTSIDE)),
            (&[[radius, height], [radius - wall, height]], Skin::Wrap(RIM)),
            (&inside, Skin::Wrap(INSIDE)),
            (&[[floor_radius, floor], [0.0, floor]], Skin::Disc(FLOOR)),
        ],
        24,
    );
    let lip = radius * shape.uniform(0.22, 0.36);
    let spread = libm::cos(shape.uniform(32.0, 46.0) * PI / 180.0);
    let poured = cup.bent(|mut p| {
        let ahead = p.x / p.xy().norm().max(1e-9);
        let share = ((ahead - spread) / (1.0 - spread)).max(0.0) * (p.z / height) * (p.z / height);
        p.x += lip * share;
        p
    });
    let grip = [radius * shape.uniform(0.16, 0.26), radius * shape.uniform(0.22, 0.34), 0.5 * wall];
    let handle = cuboid(grip, 0.3 * wall, &Faces::all(RIM));
    Draft {
        solid: poured.join(handle.moved(-radius - 0.7 * grip[0], 0.0, height - 0.6 * wall)),
        canvas,
        density: 2200.0,
    }
}
